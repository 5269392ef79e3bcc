//! Promise: every file of tests is compiled. Crates list their test programs, which name modules.

use super::workspace::crates;
use std::path::Path;

#[test]
fn every_file_of_tests_is_a_program_or_a_module_of_one() {
    let mut found = 0;
    for c in crates() {
        // Crates with a single file of tests, and those without, need no list.
        let folder = c.folder.join("tests");
        let Ok(text) = std::fs::read_to_string(folder.join("main.rs")) else { continue };
        let entries = std::fs::read_dir(&folder).expect("a folder lists");
        let programs = c.manifest.get("test").and_then(|t| t.as_array()).cloned().unwrap_or_default();
        let programs: Vec<&Path> = programs.iter().filter_map(|p| p["path"].as_str()).map(Path::new).collect();
        for path in entries.map(|e| e.expect("a folder lists").path()) {
            let is_module = path.join("mod.rs").is_file() || path.extension().is_some_and(|e| e == "rs");
            if !is_module || programs.iter().any(|p| path == c.folder.join(p)) {
                continue;
            }
            let name = path.file_stem().and_then(|s| s.to_str()).expect("a name");
            assert!(text.contains(&format!("mod {name};\n")), "{} is no module of main.rs", path.display());
            found += 1;
        }
    }
    assert!(found > 30, "{found} modules of tests");
}
