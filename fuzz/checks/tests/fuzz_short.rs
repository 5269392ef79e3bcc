//! Promise: nothing that is read can hurt. Every reader gets the same mutants of good files at every run; those are
//! refused, or what follows goes on with finite numbers.

use throng_checks::damage::READERS;

/// Mutants of each reader.
const MUTANTS: u64 = 120;

#[test]
fn mutants_of_every_kind_of_file_are_refused_or_do_no_harm() {
    let mut wrong = Vec::new();
    for reader in READERS {
        let tried = reader.try_mutants(MUTANTS, 7);
        assert_eq!(tried.bad_seeds, 0, "{}: whole files are refused", reader.name);
        assert_eq!(tried.mutants, MUTANTS);
        let refused = MUTANTS - tried.accepted - tried.faults.len() as u64;
        assert!(refused > 0, "{}: no mutant is damaged enough to be refused", reader.name);
        assert!(tried.accepted > 0, "{}: no mutant is good enough to be used", reader.name);
        wrong.extend(tried.faults.into_iter().map(|(number, what)| format!("{} {number}: {what}", reader.name)));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_reader_has_a_fuzz_target() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).expect("the manifest of the fuzz targets");
    for reader in READERS {
        assert!(manifest.contains(&format!("name = \"{}\"", reader.name)), "{} is not in the manifest", reader.name);
        let target = std::fs::read_to_string(folder.join(format!("fuzz_targets/{}.rs", reader.name)));
        let target = target.unwrap_or_else(|e| panic!("{}: {e}", reader.name));
        let call = format!("throng_checks::damage::readers::{}(data)", reader.name);
        let body = format!("#![no_main]\nlibfuzzer_sys::fuzz_target!(|data: &[u8]| {{\n    let _ = {call};\n}});\n");
        assert_eq!(target, body, "{}", reader.name);
    }
}
