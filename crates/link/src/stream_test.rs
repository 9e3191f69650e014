//! The byte stream's plant end against peers of every kind, and its document.

use super::*;
use crate::wires::{Started, StreamListener};
use std::io::Write;
use std::os::unix::net::UnixStream;
use std::process::Command;
use twinhub_types::Field;
use twinhub_types::messages::{PROTOCOL_HASH, PROTOCOL_VERSION};
use twinhub_types::stream::{ROLE_CONTROLLER, STREAM_VERSION};

fn settings() -> StreamSettings {
    StreamSettings {
        law: vec![1, 2, 3],
        patience: Some(Duration::from_secs(10)),
        stop: Arc::new(AtomicBool::new(false)),
        notice: Arc::new(|_| {}),
        who: "test".into(),
    }
}

fn wires(ours: UnixStream) -> Wires {
    Wires {
        input: ours.try_clone().expect("a socket").into(),
        output: ours.into(),
        pid: std::process::id(),
    }
}

/// A plant's end whose controller has already said `bytes` and says nothing more.
fn said(bytes: &[u8], settings: StreamSettings) -> (Result<StreamEnd, LinkError>, UnixStream) {
    let (ours, mut theirs) = UnixStream::pair().expect("sockets");
    theirs.write_all(bytes).expect("room");
    (StreamEnd::meet(wires(ours), settings), theirs)
}

fn hello() -> Vec<u8> {
    let hello = StreamHello::new(ROLE_CONTROLLER);
    Packet::of(Kind::Hello, &hello).bytes().to_vec()
}

fn frame(tick: u64) -> PlantFrame {
    let mut frame = PlantFrame::default();
    frame.header.protocol_hash = PROTOCOL_HASH;
    (frame.header.sequence, frame.header.tick) = (tick, tick);
    frame
}

fn answer(tick: u64) -> ControllerFrame {
    ControllerFrame {
        header: frame(tick).header,
        ..ControllerFrame::default()
    }
}

/// What the first exchange gives after a good hello and then `bytes`.
fn exchanged(bytes: &[u8]) -> Result<ControllerFrame, LinkError> {
    let (end, _theirs) = said(&[&hello(), bytes].concat(), settings());
    end.expect("a good hello")
        .exchange(&frame(0))
        .map(|answer| answer.expect("an answer of its own for each frame"))
}

#[test]
fn noise_before_the_hello_is_passed_over_and_answers_are_checked() {
    let good = Packet::of(Kind::Controller, &answer(0));
    let unknown = Packet::raw(Kind::Report, &[9; 16]);
    let bytes = [b"boot TW\0", &hello()[..], unknown.bytes(), good.bytes()].concat();
    let (end, _theirs) = said(&bytes, settings());
    let found = end.expect("met").exchange(&frame(0)).expect("met");
    let found = found.expect("answered");
    assert_eq!(found.header, frame(0).header);

    let text = |bytes: &[u8]| exchanged(bytes).expect_err("broken").to_string();
    let late = Packet::of(Kind::Controller, &answer(7));
    assert!(text(late.bytes()).contains("sequence is 0x7, expected 0x0"));
    let short = Packet::raw(Kind::Controller, &[0; 95]);
    assert!(text(short.bytes()).contains("95 bytes, expected 96"));
    assert!(text(b"xyz").contains("0x78 stands outside"));
    assert!(text(b"TWHB\x04\0\xff\xff").contains("65535 bytes is announced; at most 512"));
    let mut flipped = good.bytes().to_vec();
    flipped[50] ^= 4;
    assert!(text(&flipped).contains("checksum"));
    let mut foreign = answer(0);
    foreign.header.protocol_hash = 5;
    let foreign = Packet::of(Kind::Controller, &foreign);
    assert!(text(foreign.bytes()).contains("protocol_hash is 0x5"));
}

#[test]
fn another_layout_is_refused_with_both_sides_named() {
    let mut other = StreamHello::new(ROLE_CONTROLLER);
    other.protocol_hash = 0xabc;
    let (end, _theirs) = said(Packet::of(Kind::Hello, &other).bytes(), settings());
    let text = end.err().expect("refused").to_string();
    assert!(text.contains("another message layout"), "{text}");
    assert!(text.contains("0000000000000abc"), "{text}");
    assert!(text.contains(&format!("{PROTOCOL_HASH:016x}")), "{text}");
}

#[test]
fn silence_chatter_and_a_stop_all_end() {
    let short = |patience| StreamSettings {
        patience: Some(patience),
        ..settings()
    };
    let (end, _theirs) = said(b"", short(Duration::from_millis(30)));
    assert!(matches!(end, Err(LinkError::Silent { .. })));
    // Talks without end and says no hello.
    let (ours, mut theirs) = UnixStream::pair().expect("sockets");
    let talker = std::thread::spawn(move || while theirs.write_all(&[b'x'; 512]).is_ok() {});
    let end = StreamEnd::meet(wires(ours), short(Duration::from_millis(50)));
    assert!(matches!(end, Err(LinkError::Silent { .. })));
    drop(end);
    talker.join().expect("stops when nobody listens");
    let stopped = settings();
    stopped.stop.store(true, Ordering::Relaxed);
    let (end, _theirs) = said(&hello(), stopped);
    let end = end
        .expect("a hello that is there is taken")
        .exchange(&frame(0));
    assert!(matches!(end, Err(LinkError::Interrupted)));
}

#[test]
fn a_peer_that_hangs_up_has_left_and_one_that_is_killed_has_died() {
    let (end, theirs) = said(&hello(), settings());
    drop(theirs);
    let mut end = end.expect("met");
    assert!(matches!(
        end.exchange(&frame(3)),
        Err(LinkError::PeerLeft { tick: 3, .. })
    ));

    let hello: String = hello().iter().map(|byte| format!("\\{byte:03o}")).collect();
    // Long enough alive to be met, not long enough to answer.
    let script = format!("printf '{hello}'; sleep 0.2; kill -9 $$");
    let (started, wires) =
        Started::piped(Command::new("sh").args(["-c", &script])).expect("a shell");
    let mut end = StreamEnd::meet(wires, settings()).expect("met");
    let error = end.exchange(&frame(4)).expect_err("killed");
    assert!(
        matches!(error, LinkError::PeerDied { pid, .. } if pid == started.pid()),
        "{error}"
    );
}

#[test]
fn a_socket_is_private_and_goes_with_its_ride() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("ride.sock");
    let listener = StreamListener::bind(&path).expect("a socket");
    let mode = std::fs::metadata(&path)
        .expect("there")
        .permissions()
        .mode();
    assert_eq!(mode & 0o777, 0o600);
    assert!(StreamListener::bind(&path).is_err(), "taken");
    let stop = AtomicBool::new(false);
    let short = Some(Duration::from_millis(30));
    assert!(matches!(
        listener.accept(short, &stop),
        Err(LinkError::Silent { .. })
    ));
    let _visitor = UnixStream::connect(&path).expect("connects");
    let wires = listener.accept(short, &stop).expect("somebody");
    assert_eq!(wires.pid, std::process::id());
    drop(listener);
    assert!(!path.exists());
}

/// The table of a message: every field with its place.
fn table(name: &str, fields: &[Field]) -> String {
    let mut text = format!("### {name}\n| bytes | type | field |\n|---|---|---|\n");
    let mut at = 0;
    rows(fields, "", &mut at, &mut text);
    text + "\n"
}

fn rows(fields: &[Field], prefix: &str, at: &mut usize, text: &mut String) {
    for field in fields {
        let name = format!("{prefix}{}", field.name);
        if !field.nested.is_empty() {
            rows(field.nested, &format!("{name}."), at, text);
            continue;
        }
        let bytes = field.len * if field.kind == "u64" { 8 } else { 4 };
        let kind = match field.len {
            1 => field.kind.to_owned(),
            n => format!("{} x {n}", field.kind),
        };
        *text += &format!("| {}-{} | {kind} | `{name}` |\n", at, *at + bytes - 1);
        *at += bytes;
    }
}

#[test]
fn the_document_and_the_examples_have_todays_layout() {
    let tables = [
        table("Hello", StreamHello::FIELDS),
        table("Plant frame", PlantFrame::FIELDS),
        table("Controller frame", ControllerFrame::FIELDS),
        table("Target report", TargetReport::FIELDS),
    ]
    .concat();
    let document = include_str!("../STREAM.md");
    let line = format!(
        "Layout hash `0x{PROTOCOL_HASH:016x}`, stream version {STREAM_VERSION}, protocol version {PROTOCOL_VERSION}."
    );
    assert!(document.contains(&line), "STREAM.md should say: {line}");
    assert!(
        document.contains(&tables),
        "STREAM.md should hold these tables:\n{tables}"
    );
    let hash = format!("0x{PROTOCOL_HASH:x}");
    for example in [
        include_str!("../controllers/controller.py"),
        include_str!("../controllers/controller.c"),
    ] {
        assert!(
            example.contains(&hash),
            "an example should be written for {hash}"
        );
    }
    let bytes = 2 * (8 + 4) + PlantFrame::SIZE + ControllerFrame::SIZE;
    assert!(
        document.contains(&format!("a tick moves {bytes} bytes")),
        "{bytes} bytes"
    );
}
