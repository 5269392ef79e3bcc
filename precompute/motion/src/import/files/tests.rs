use super::*;

#[test]
fn stars_stand_for_any_text() {
    for (pattern, name, hit) in [
        ("walk*.bvh", "walk_1.bvh", true),
        ("*walk*.bvh", "a_walk_1.bvh", true),
        ("*walk*.bvh", "walk.bvh", true),
        ("walk*.bvh", "run.bvh", false),
        ("ab*ba", "aba", false),
        ("*", "x", true),
        ("a*b*c", "abbc", true),
        ("a*b*c", "acb", false),
        ("a.bvh", "a.bvh", true),
    ] {
        assert_eq!(matches(pattern, name), hit, "{pattern} {name}");
    }
}

#[test]
fn a_skeleton_is_chosen_by_stem_and_else_refused_with_the_candidates() {
    let dir = tempfile::tempdir().unwrap();
    let put = |name: &str| std::fs::write(dir.path().join(name), "").unwrap();
    let amc = dir.path().join("02_01.amc");
    assert!(find_asf(&amc).unwrap_err().to_string().contains("no ASF file"));
    put("x.asf");
    assert!(find_asf(&amc).unwrap().ends_with("x.asf"));
    put("02.asf");
    assert!(find_asf(&amc).unwrap().ends_with("02.asf"));
    let e = find_asf(&dir.path().join("walk.amc")).unwrap_err().to_string();
    assert!(e.contains("02.asf") && e.contains("x.asf") && e.contains("Begin its name with"), "{e}");
}

#[test]
fn folders_give_their_motion_files_sorted() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["b.BVH", "a.amc", "a.asf", "c.txt"] {
        std::fs::write(dir.path().join(name), "").unwrap();
    }
    let names = |p: &Path| {
        let files = expand(&[p.to_owned(), dir.path().join("a.amc")]).unwrap();
        files.iter().map(|f| f.file_name().unwrap().to_string_lossy().into_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names(dir.path()), ["a.amc", "b.BVH"]);
    assert_eq!(names(&dir.path().join("*.BVH")), ["a.amc", "b.BVH"]);
    assert!(expand(&[dir.path().join("z*")]).is_err());
}

/// A folder with `one.bvh`, `deep/er/two.BVH`, `deep/three.amc`, an archive and what is to be passed over.
fn tree() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let put = |name: &str| {
        let path = dir.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, name).unwrap();
    };
    let all = ["one.bvh", "deep/er/two.BVH", "deep/three.amc", "deep/a.asf", "read me.txt", ".git/four.bvh"];
    all.into_iter().for_each(put);
    put("deep/._three.amc");
    let file = std::fs::File::create(dir.path().join("more.zip")).unwrap();
    let mut zip = zip::ZipWriter::new(file);
    for (name, method) in
        [("x/five.bvh", zip::CompressionMethod::Deflated), ("x/b.asf", zip::CompressionMethod::Stored)]
    {
        let options = zip::write::SimpleFileOptions::default().compression_method(method);
        zip.start_file(name, options).unwrap();
        std::io::Write::write_all(&mut zip, name.as_bytes()).unwrap();
    }
    for name in ["__MACOSX/x/five.bvh", "x/six.amc"] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
    }
    zip.finish().unwrap();
    dir
}

fn names(dir: &tempfile::TempDir, path: &str) -> Vec<String> {
    find_motion_files(&[dir.path().join(path)]).unwrap().into_iter().map(|f| f.name).collect()
}

#[test]
fn folders_and_archives_are_searched_to_any_depth_and_names_are_relative_to_what_was_given() {
    let dir = tree();
    let all = ["deep/er/two", "deep/three", "more.zip/x/five", "more.zip/x/six", "one"];
    assert_eq!(names(&dir, ""), all);
    assert_eq!(names(&dir, "deep"), ["er/two", "three"]);
    assert_eq!(names(&dir, "more.zip"), ["x/five", "x/six"]);
    assert_eq!(names(&dir, "more.zip/x/five.bvh"), ["five"]);
    assert_eq!(names(&dir, "deep/er/two.BVH"), ["two"]);
}

#[test]
fn two_stars_stand_for_any_number_of_folders() {
    let dir = tree();
    assert_eq!(names(&dir, "**/*.BVH"), ["deep/er/two"]);
    assert_eq!(names(&dir, "**/t*"), ["deep/er/two", "deep/three"]);
    assert_eq!(names(&dir, "**"), names(&dir, ""));
    assert_eq!(names(&dir, "d*/t*.amc"), ["deep/three"]);
    assert_eq!(names(&dir, "*/*/*"), ["deep/er/two"]);
    assert!(find_motion_files(&[dir.path().join("d*/**/o*")]).is_err());
}

#[cfg(unix)]
#[test]
fn links_that_lead_back_end() {
    let dir = tree();
    std::os::unix::fs::symlink(dir.path(), dir.path().join("deep/again")).unwrap();
    assert_eq!(names(&dir, "").len(), 5);
    assert_eq!(names(&dir, "**/one.bvh"), ["one"]);
}

#[test]
fn packed_length_counts_and_archives_whose_files_share_bytes_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, twice: bool| {
        let mut zip = zip::ZipWriter::new(std::fs::File::create(dir.path().join(name)).unwrap());
        zip.start_file("a.bvh", zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, &[b' '; 1 << 20]).unwrap();
        if twice {
            zip.shallow_copy_file("a.bvh", "b.bvh").unwrap();
        }
        zip.finish().unwrap();
    };
    write("once.zip", false);
    write("twice.zip", true);
    let inside = dir.path().join("once.zip/a.bvh");
    let whole = archive::read_file(&inside, "motion", 1 << 30).unwrap().len();
    let counted = archive::counted_bytes(&inside, whole);
    assert!((1 << 16..1 << 18).contains(&counted), "{counted} of {whole} bytes");
    assert_eq!(archive::counted_bytes(&dir.path().join("a.bvh"), whole), whole, "in no archive");
    let e = archive::members(&dir.path().join("twice.zip")).unwrap_err().to_string();
    assert!(e.contains("twice.zip: two of its files lie in the same place"), "{e}");
}

#[test]
fn files_in_archives_are_read_up_to_a_limit_and_find_their_skeleton() {
    let dir = tree();
    let (zip, at) = (dir.path().join("more.zip"), |m: &str| dir.path().join("more.zip").join(m));
    assert_eq!(archive::read_file(&at("x/five.bvh"), "motion", 100).unwrap(), b"x/five.bvh");
    assert!(
        archive::read_file(&at("x/five.bvh"), "motion", 9)
            .unwrap_err()
            .to_string()
            .contains("five.bvh: 0.0 MB in the archive become more")
    );
    assert!(archive::read_file(&at("x/seven.bvh"), "motion", 9).unwrap_err().to_string().contains("seven.bvh"));
    assert_eq!(find_asf(&at("x/six.amc")).unwrap(), at("x/b.asf"));
    assert!(archive::is_file(&at("x/b.asf")) && !archive::is_file(&at("b.asf")));
    // What leads out of it is not found.
    let out = dir.path().join("out.zip");
    for outside in ["/etc/x.bvh", "../x.bvh", "a/../../x.bvh", "C:x.bvh", "a\\x.bvh", "./x.bvh"] {
        // As long as the name that is put in its place, which the program that writes archives would not take.
        let plain = "x".repeat(outside.len());
        let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        zip.start_file(&plain, zip::write::SimpleFileOptions::default()).unwrap();
        let bytes = zip.finish().unwrap().into_inner();
        let text = bytes.iter().map(|b| char::from(*b)).collect::<String>().replace(&plain, outside);
        std::fs::write(&out, text.chars().map(|c| c as u8).collect::<Vec<_>>()).unwrap();
        assert_eq!(archive::members(&out).unwrap(), [] as [&str; 0], "{outside}");
    }
    std::fs::remove_file(&out).unwrap();
    // Every byte may be wrong: nothing panics.
    let good = std::fs::read(&zip).unwrap();
    for i in 0..good.len() {
        let mut bad = good.clone();
        bad[i] ^= 0x55;
        std::fs::write(&zip, &bad[..]).unwrap();
        for file in find_motion_files(std::slice::from_ref(&zip)).unwrap_or_default() {
            _ = archive::read_file(&file.path, "motion", 99);
        }
    }
    std::fs::write(&zip, "no archive").unwrap();
    assert!(find_motion_files(&[zip]).unwrap_err().to_string().contains("more.zip: it is no archive that can be read"));
    // A folder is no worse for it: the archive is a file that cannot be read.
    assert_eq!(names(&dir, ""), ["deep/er/two", "deep/three", "more", "one"]);
}

/// The bytes of an archive of some files.
fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn archives_in_archives_are_searched_and_no_deeper() {
    let dir = tempfile::tempdir().unwrap();
    let third = zipped(&[("deep.bvh", b"deep")]);
    let inner = zipped(&[("walk/slow.bvh", b"slow"), ("run.bvh", b"run"), ("third.zip", &third)]);
    let bomb = zipped(&[("a.bvh", &vec![b' '; 50 << 20])]);
    let outer = zipped(&[("set.zip", &inner), ("one.bvh", b"one"), ("bad.zip", b"no archive"), ("bomb.zip", &bomb)]);
    std::fs::write(dir.path().join("all.zip"), outer).unwrap();
    assert_eq!(
        names(&dir, "all.zip"),
        ["bad", "bomb.zip/a", "one", "set.zip/run", "set.zip/third", "set.zip/walk/slow"],
        "the third level and what is damaged are kept to be told"
    );
    let e = crate::import::read_source(&dir.path().join("all.zip/set.zip/third.zip"), None).err().unwrap().to_string();
    assert!(e.contains("third.zip: it lies in an archive that lies in another one") && e.contains("Unpack"), "{e}");
    let at = |m: &str| dir.path().join("all.zip").join(m);
    assert_eq!(archive::read_file(&at("set.zip/walk/slow.bvh"), "motion", 100).unwrap(), b"slow");
    assert_eq!(archive::read_file(&at("one.bvh"), "motion", 100).unwrap(), b"one");
    assert!(archive::is_file(&at("set.zip/run.bvh")) && !archive::is_file(&at("set.zip/gone.bvh")));
    assert!(!archive::is_file(&at("set.zip/third.zip/deep.bvh")));
    assert_eq!(names(&dir, "all.zip/set.zip"), ["run", "third", "walk/slow"]);
    // An archive of zeros that are packed twice.
    let twice = zipped(&[("bomb.zip", &vec![0; 64 << 20])]);
    std::fs::write(dir.path().join("twice.zip"), twice).unwrap();
    let e = archive::members(&dir.path().join("twice.zip/bomb.zip")).unwrap_err().to_string();
    assert!(e.contains("bomb.zip: 0.1 MB in the archive become more than the 1 MB that an archive"), "{e}");
}

/// 100 MB that repeat take a hundred kilobytes: more than two hundred times of that is refused before all of it is in memory.
#[test]
fn little_of_an_archive_does_not_become_all_of_memory() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bomb.zip");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    zip.start_file("a.bvh", zip::write::SimpleFileOptions::default()).unwrap();
    std::io::copy(&mut std::io::Read::take(std::io::repeat(b' '), 100_000_000), &mut zip).unwrap();
    zip.finish().unwrap();
    let mut read = Vec::new();
    let e = archive::copy_file(&path.join("a.bvh"), "motion", u64::MAX, &mut read).unwrap_err().to_string();
    assert!(e.contains("a.bvh: 0.1 MB in the archive become more than the") && read.len() < 100_000_000, "{e}");
}

/// Each `**` may stand for any of the folders that lead to a place.
#[test]
fn patterns_of_many_folders_take_no_longer() {
    let dir = tempfile::tempdir().unwrap();
    let deep = (0..40).fold(dir.path().to_owned(), |at, _| at.join("a"));
    std::fs::create_dir_all(&deep).unwrap();
    std::fs::write(deep.join("one.bvh"), "").unwrap();
    let pattern = "**/a/".repeat(12) + "*.bvh";
    assert_eq!(names(&dir, &pattern), [format!("{}one", "a/".repeat(40))]);
}
