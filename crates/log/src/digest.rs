//! The digest of a ride: equal exactly if the tick records are equal, bit for bit and in order.

/// Computes the digest record by record. How the records are grouped does not matter.
#[derive(Clone, Default)]
pub struct DigestStream {
    hasher: blake3::Hasher,
    pending: Vec<u8>,
}

/// BLAKE3 is fastest on several kilobytes at a time.
const CHUNK: usize = 16 * 1024;

impl DigestStream {
    /// Takes in one record. Lengths go in too, so that bytes cannot move between fields.
    #[inline]
    pub fn add(&mut self, topic: &str, publish_time_ns: u64, payload: &[u8]) {
        self.pending
            .extend_from_slice(&(topic.len() as u64).to_le_bytes());
        self.pending.extend_from_slice(topic.as_bytes());
        self.pending
            .extend_from_slice(&publish_time_ns.to_le_bytes());
        self.pending
            .extend_from_slice(&(payload.len() as u64).to_le_bytes());
        self.pending.extend_from_slice(payload);
        if self.pending.len() >= CHUNK {
            self.hasher.update(&self.pending);
            self.pending.clear();
        }
    }

    /// The digest so far: 32 hex characters.
    pub fn hex(&self) -> String {
        let mut hasher = self.hasher.clone();
        hasher.update(&self.pending);
        hex(&hasher)
    }
}

/// The digest of a text, for the digest of a configuration: 32 hex characters.
pub fn digest_text(text: &str) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(text.as_bytes());
    hex(&hasher)
}

fn hex(hasher: &blake3::Hasher) -> String {
    hasher.finalize().to_hex()[..32].to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn digest(records: &[(&str, u64, &[u8])]) -> String {
        let mut stream = DigestStream::default();
        for (topic, time, payload) in records {
            stream.add(topic, *time, payload);
        }
        stream.hex()
    }

    #[test]
    fn every_part_and_the_order_count() {
        let base = digest(&[("/a", 1, b"xy"), ("/b", 2, b"z")]);
        assert_eq!(base.len(), 32);
        assert_eq!(base, digest(&[("/a", 1, b"xy"), ("/b", 2, b"z")]));
        for other in [
            digest(&[("/b", 2, b"z"), ("/a", 1, b"xy")]),
            digest(&[("/a", 1, b"xy"), ("/b", 3, b"z")]),
            digest(&[("/a", 1, b"xy"), ("/b", 2, b"y")]),
            digest(&[("/a", 1, b"xy"), ("/c", 2, b"z")]),
            digest(&[("/a", 1, b"xy")]),
            digest(&[("/a", 1, b"xyz")]),
            digest(&[]),
        ] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn the_empty_text_has_the_published_blake3_digest() {
        // First half of the test vector for empty input, BLAKE3 specification.
        assert_eq!(digest_text(""), "af1349b9f5f9a1a6a0404dea36dcc949");
    }

    #[test]
    fn a_long_stream_equals_the_hash_of_the_whole() {
        let payload = [7u8; 999];
        let mut stream = DigestStream::default();
        let mut whole = Vec::new();
        for time in 0..50u64 {
            stream.add("/t", time, &payload);
            whole.extend_from_slice(&2u64.to_le_bytes());
            whole.extend_from_slice(b"/t");
            whole.extend_from_slice(&time.to_le_bytes());
            whole.extend_from_slice(&999u64.to_le_bytes());
            whole.extend_from_slice(&payload);
        }
        assert_eq!(stream.hex(), blake3::hash(&whole).to_hex()[..32]);
    }
}
