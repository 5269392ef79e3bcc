//! A bundle that is open does not see what happens to its file.

use crate::common::{bundle, tables};
use std::fs::OpenOptions;
use std::io::Write;
use throng_core::base::Hash128;
use throng_core::characters::{CharactersConfig, PolicyCharacters, Spawn};
use throng_core::format::FormatError;
use throng_core::{Bundle, CharacterGroup, Inline, Planar};

/// Poses and values that come from every part of the tables.
fn use_it(tables: &Bundle) -> (u128, u128, u64) {
    let mut values = Hash128::default();
    for frame in tables.frames().iter() {
        frame.planar.iter().for_each(|v| values.add_bytes(&v.to_le_bytes()));
    }
    let policy = &tables.policies()[0];
    for state in 0..tables.graph().states.len() as u32 {
        values.add_bytes(&policy.value(state, throng_core::glam::Vec3::new(1.0, 0.0, 2.0)).to_le_bytes());
    }
    let mut group = PolicyCharacters::with_capacity(tables, 4, CharactersConfig::default()).expect("characters");
    for i in 0..4 {
        group.spawn(Spawn::standing_at(Planar::new(i as f32, 0.0, 0.0))).expect("a place");
    }
    (0..200).for_each(|_| group.step(1.0 / 60.0, &Inline).expect("a step"));
    (tables.hash(), values.finish(), group.hash())
}

#[test]
fn what_is_open_goes_on_when_its_file_is_cut_short_and_overwritten_in_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.throng");
    let expected = use_it(&tables());
    for (name, open) in [
        ("open", (|p| Bundle::open(p)) as fn(&std::path::Path) -> Result<Bundle, FormatError>),
        ("open_unverified", |p| Bundle::open_unverified(p)),
    ] {
        std::fs::write(&path, bundle()).expect("a file");
        let opened = open(&path).expect("a bundle");
        OpenOptions::new().write(true).open(&path).expect("the file").set_len(100).expect("a length");
        assert_eq!(use_it(&opened), expected, "{name}, cut short");

        std::fs::write(&path, bundle()).expect("a file");
        let opened = open(&path).expect("a bundle");
        let mut file = OpenOptions::new().write(true).open(&path).expect("the file");
        file.write_all(&vec![0xff; bundle().len()]).expect("written");
        assert_eq!(use_it(&opened), expected, "{name}, overwritten");
    }
}

#[test]
#[allow(unsafe_code)]
fn a_file_that_is_mapped_says_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.throng");
    std::fs::write(&path, bundle()).expect("a file");
    // SAFETY: nobody knows of the file.
    let mapped = unsafe { Bundle::map(&path) }.expect("a bundle");
    assert_eq!(use_it(&mapped), use_it(&tables()));
    // SAFETY: as above.
    let mapped = unsafe { Bundle::map_unverified(&path) }.expect("a bundle");
    assert_eq!(use_it(&mapped), use_it(&tables()));
}

#[test]
#[allow(unsafe_code)]
fn what_is_no_regular_file_is_refused_by_all_ways() {
    let folder = tempfile::tempdir().expect("a folder");
    // SAFETY: a folder is not mapped.
    let mapped = unsafe { Bundle::map(folder.path()) };
    for refused in [Bundle::open(folder.path()), Bundle::open_unverified(folder.path()), mapped] {
        let e = refused.expect_err("a folder is no bundle");
        assert!(
            matches!(e, FormatError::File { .. }) && e.to_string().contains("is a folder, expected a bundle"),
            "{e}"
        );
    }
    #[cfg(unix)]
    assert!(matches!(Bundle::open("/dev/zero"), Err(FormatError::File { .. })));
}
