//! Logs as files: written, read back, cut, damaged, killed.

mod recording;

use recording::*;
use std::path::Path;

use twinhub_log::{
    BATCH, CONTROL_OUTPUT, Digest, IN_FLIGHT_MAX, LogError, PLANT_TRUTH, RIDER_STATE, RideLog,
    SENSOR_MEASUREMENT, check_layouts, read,
};
use twinhub_types::Instant;

#[test]
fn a_ride_comes_back_as_it_was() {
    let dir = tempfile::tempdir().expect("dir");
    let path = dir.path().join("ride.mcap");
    let summary = ride(&path, 2_000, 0.5, 3.0);
    let log = read(&path).expect("read");
    assert!(!log.recovered(), "{:?}", log.recovery);
    log.verify().expect("digest");
    assert_eq!(log.digest, summary.digest);
    assert_eq!(summary.messages, 6 * 2_000 + 40 + 1);
    assert_eq!(summary.bytes, std::fs::metadata(&path).expect("file").len());
    assert_eq!(log.config_text(), Some(CONFIG));
    for (key, value) in [
        ("version", "1.2.3"),
        ("seed", "7"),
        ("git_hash", "abc"),
        ("course", "first"),
        ("fell", "no"),
    ] {
        assert_eq!(log.about(key), Some(value), "{key}");
    }
    let roll = log.column(PLANT_TRUTH, "roll_rad").expect("column");
    assert_eq!((roll.len(), roll[3], roll[1_999]), (2_000, 0.5, 1.999));
    assert_eq!(
        log.column(SENSOR_MEASUREMENT, "imu.gyro_rad_s.2")
            .expect("column")[77],
        77.0
    );
    assert_eq!(
        log.column(SENSOR_MEASUREMENT, "imu.stamp_ns")
            .expect("column")[77],
        77e6
    );
    assert!(
        log.column(SENSOR_MEASUREMENT, "roll.stamp_ns")
            .expect("column")[77]
            .is_nan()
    );
    assert_eq!(
        log.column(CONTROL_OUTPUT, "estimate.roll_rad")
            .expect("column")[3],
        0.5
    );
    assert_eq!(
        log.column(CONTROL_OUTPUT, "health").expect("column")[3],
        5.0
    );
    assert_eq!(log.table(RIDER_STATE).expect("table").times_s()[1_500], 1.5);
    assert_eq!(log.texts["/event"].len(), 1);
    assert_eq!(log.texts["/scene"].len(), 40);
    assert!(log.undecoded.is_empty(), "{:?}", log.undecoded);
    check_layouts(&log).expect("layouts");
    let error = log
        .column(PLANT_TRUTH, "rol_rad")
        .expect_err("no such column")
        .to_string();
    assert!(
        error.contains("rol_rad") && error.contains("roll_rad, steer_rad"),
        "{error}"
    );
    assert!(log.table("/plant").is_err());
}

#[test]
fn the_digest_sees_every_bit_of_the_ride_and_nothing_else() {
    let dir = tempfile::tempdir().expect("dir");
    let digest =
        |name: &str, roll: f64, timing: f64| ride(&dir.path().join(name), 100, roll, timing).digest;
    let base = digest("a", 0.5, 3.0);
    assert_eq!(base, digest("b", 0.5, 3.0));
    assert_eq!(base, digest("c", 0.5, 9.0), "link timing does not enter");
    assert_ne!(base, digest("d", 0.5 + f64::EPSILON, 3.0));
}

/// Computed with Python's `mcap` and `blake3` from the definition of the digest; changes if the
/// definition, the alignment or the byte order does.
#[test]
fn the_digest_is_the_one_that_other_tools_compute() {
    let dir = tempfile::tempdir().expect("dir");
    let path = dir.path().join("fixed.mcap");
    let mut log = RideLog::create(&path, &metadata(), CONFIG).expect("create");
    let topic = log
        .topic::<RiderRow>(RIDER_STATE, Digest::Digested)
        .expect("topic");
    for tick in 0..100u32 {
        let row = RiderRow {
            steer_torque_nm: f64::from(tick) / 8.0,
            wanted_speed_m_s: -6.5,
        };
        log.write(
            topic,
            Instant::from_nanos(u64::from(tick) * 1_000_000),
            &row,
        )
        .expect("write");
    }
    assert_eq!(
        log.finish().expect("finish").digest,
        "5b4ad93f4b5c4e18f2cdc6b6be85e97c"
    );
}

#[test]
fn a_dropped_log_is_complete() {
    let dir = tempfile::tempdir().expect("dir");
    let path = dir.path().join("dropped.mcap");
    let mut log = RideLog::create(&path, &metadata(), CONFIG).expect("create");
    let topic = log
        .topic::<RiderRow>(RIDER_STATE, Digest::Digested)
        .expect("topic");
    log.write(topic, Instant::START, &RiderRow::default())
        .expect("write");
    drop(log);
    let log = read(&path).expect("read");
    log.verify().expect("digest");
    assert!(!log.recovered());
    assert_eq!(log.table(RIDER_STATE).expect("table").len(), 1);
}

/// What a kill leaves is the file as it is at some moment; here it is looked at after every tick.
#[test]
fn at_any_moment_the_file_lacks_at_most_100_ms() {
    assert!(IN_FLIGHT_MAX.as_nanos() <= 100_000_000 && BATCH.as_nanos() <= 50_000_000);
    let dir = tempfile::tempdir().expect("dir");
    let path = dir.path().join("killed.mcap");
    let copy = path.clone();
    let mut worst = 0;
    ride_with(&path, 700, 0.5, 3.0, |tick| {
        if tick % 7 == 0 && tick > 100 {
            let log = read(&copy).unwrap_or_else(|e| panic!("tick {tick}: {e}"));
            assert!(log.recovered());
            let last = log
                .table(PLANT_TRUTH)
                .expect("table")
                .publish_time_ns
                .last()
                .map_or(0, |ns| ns / 1_000_000);
            worst = worst.max(tick - last);
        }
    });
    assert!(worst <= 100, "{worst} ms were not in the file");
    assert!(
        worst > 0,
        "the look at the file came too late to show anything"
    );
}

#[test]
fn a_cut_file_gives_every_whole_chunk_and_says_so() {
    let dir = tempfile::tempdir().expect("dir");
    let path = dir.path().join("ride.mcap");
    ride(&path, 400, 0.5, 3.0);
    let bytes = std::fs::read(&path).expect("read");
    let full = read(&path).expect("read");
    let cut = dir.path().join("cut.mcap");
    let mut lengths = Vec::new();
    for part in 1..40 {
        std::fs::write(&cut, &bytes[..bytes.len() * part / 40]).expect("write");
        let log = match read(&cut) {
            Ok(log) => log,
            Err(LogError::Nothing { .. }) => continue,
            Err(error) => panic!("{error}"),
        };
        assert!(log.recovered());
        let recovery = log.recovery.as_ref().expect("recovered");
        assert_eq!(
            recovery.used_bytes + recovery.lost_bytes,
            (bytes.len() * part / 40) as u64
        );
        let Ok(table) = log.table(PLANT_TRUTH) else {
            continue;
        };
        assert_eq!(table.len() % 20, 0, "whole chunks of 20 ms");
        assert_eq!(
            table.columns[0].values[..],
            full.tables[PLANT_TRUTH].columns[0].values[..table.len()]
        );
        lengths.push(table.len());
    }
    assert!(
        lengths.is_sorted() && lengths.len() > 20 && *lengths.last().expect("some") >= 340,
        "{lengths:?}"
    );
}

#[test]
fn damage_is_found() {
    let dir = tempfile::tempdir().expect("dir");
    let path = dir.path().join("ride.mcap");
    ride(&path, 400, 0.5, 3.0);
    let mut bytes = std::fs::read(&path).expect("read");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, &bytes).expect("write");
    let log = read(&path).expect("the first half is readable");
    let reason = &log.recovery.as_ref().expect("damage is noticed").reason;
    assert!(
        reason.contains("checksum") || reason.contains("record"),
        "{reason}"
    );
    assert!(matches!(log.verify(), Err(LogError::NoDigest { .. })));
}

#[test]
fn what_is_no_log_is_named() {
    let dir = tempfile::tempdir().expect("dir");
    let path = dir.path().join("x.mcap");
    for (content, words) in [
        (&b""[..], "it is empty"),
        (b"roll,steer\n1,2\n", "the text \"roll,ste\""),
        (b"\x1f\x8b\x08\x00", "the bytes 1f 8b 08 00"),
        (&mcap::MAGIC[..5], "the bytes 89 4d 43 41 50"),
        (mcap::MAGIC, "nothing can be recovered"),
        (
            b"\x89MCAP0\r\n\x01\xff\xff\xff\xff\xff\xff\xff\xff",
            "nothing can be recovered",
        ),
        (
            b"\x89MCAP0\r\n\x01\x08\0\0\0\0\0\0\0\xff\xff\xff\xff\0\0\0\0",
            "nothing can be recovered",
        ),
    ] {
        std::fs::write(&path, content).expect("write");
        let error = read(&path).expect_err("no log").to_string();
        assert!(error.contains(words) && error.contains("x.mcap"), "{error}");
    }
    assert!(matches!(
        read(dir.path().join("absent")),
        Err(LogError::Read { .. })
    ));
    assert!(matches!(read(dir.path()), Err(LogError::Read { .. })));
    let nowhere = dir.path().join("no/such/dir/x.mcap");
    assert!(matches!(
        RideLog::create(&nowhere, &metadata(), CONFIG),
        Err(LogError::Create { .. })
    ));
}

#[test]
fn a_topic_needs_a_name_of_its_own() {
    let dir = tempfile::tempdir().expect("dir");
    let mut log = RideLog::create(&dir.path().join("x.mcap"), &metadata(), CONFIG).expect("create");
    log.topic::<RiderRow>("/a", Digest::Left).expect("first");
    for name in ["/a", "a", "/", "/a b", "/event"] {
        assert!(
            matches!(
                log.topic::<RiderRow>(name, Digest::Left),
                Err(LogError::Topic { .. })
            ),
            "{name}"
        );
    }
}

#[test]
fn a_full_disk_is_reported() {
    if !Path::new("/dev/full").exists() {
        println!("skipped: there is no /dev/full here");
        return;
    }
    let mut log = match RideLog::create(Path::new("/dev/full"), &metadata(), CONFIG) {
        Err(LogError::Write { .. }) => return,
        Err(error) => panic!("{error}"),
        Ok(log) => log,
    };
    let topic = log
        .topic::<RiderRow>(RIDER_STATE, Digest::Digested)
        .expect("topic");
    let failed = (0..100_000).find_map(|tick| {
        log.write(
            topic,
            Instant::from_nanos(tick * 1_000_000),
            &RiderRow::default(),
        )
        .err()
    });
    assert!(matches!(failed, Some(LogError::Write { .. })), "{failed:?}");
}

mod damage {
    use super::*;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    static RIDE: LazyLock<Vec<u8>> = LazyLock::new(|| {
        let dir = tempfile::tempdir().expect("dir");
        let path = dir.path().join("ride.mcap");
        ride(&path, 45, 0.5, 3.0);
        std::fs::read(&path).expect("read")
    });

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        #[test]
        fn no_damage_makes_the_reader_panic(
            keep in 0.0..1.2f64,
            flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
            head in prop::collection::vec((0usize..400, any::<u8>()), 0..3),
        ) {
            let mut bytes = RIDE.clone();
            for (at, value) in flips {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            for (at, value) in head {
                bytes[at] = value;
            }
            let keep = (bytes.len() as f64 * keep) as usize;
            bytes.truncate(keep);
            let dir = tempfile::tempdir().expect("dir");
            let path = dir.path().join("damaged.mcap");
            std::fs::write(&path, &bytes).expect("write");
            if let Ok(log) = read(&path) && !log.recovered() && log.verify().is_ok() {
                // Whatever was hit, the records are those of the ride.
                prop_assert_eq!(log.table(PLANT_TRUTH).expect("table").len(), 45);
            }
        }

        #[test]
        fn noise_after_the_magic_is_no_log(noise in prop::collection::vec(any::<u8>(), 0..300)) {
            let dir = tempfile::tempdir().expect("dir");
            let path = dir.path().join("noise.mcap");
            std::fs::write(&path, [mcap::MAGIC, &noise[..]].concat()).expect("write");
            if let Ok(log) = read(&path) {
                prop_assert!(log.tables.is_empty());
            }
        }
    }
}
