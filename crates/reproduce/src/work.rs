//! Independent parts on several threads; results in order.

use std::sync::atomic::{AtomicUsize, Ordering};

/// `part(0..parts)` on `threads` threads; `progress` is told how many are done, and of how many.
pub(crate) fn shared<T: Send>(
    parts: usize,
    threads: usize,
    progress: &(dyn Fn(usize, usize) + Sync),
    part: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let mut results = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= parts {
                return results;
            }
            results.push((k, part(k)));
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, parts);
        }
    };
    let mut results: Vec<(usize, T)> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
        let joined = handles.into_iter().map(|h| match h.join() {
            Ok(results) => results,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        joined.flatten().collect()
    });
    results.sort_by_key(|(k, _)| *k);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn results_come_in_order() {
        let squares = super::shared(50, 3, &|_, of| assert_eq!(of, 50), |k| k * k);
        assert_eq!(squares, (0..50).map(|k| k * k).collect::<Vec<_>>());
        assert!(super::shared(0, 2, &|_, _| {}, |k| k).is_empty());
    }
}
