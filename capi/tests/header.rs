//! The header says what the library has. `UPDATE_HEADER=1 cargo test -p throng-capi --test all header` writes it.

use std::path::Path;

#[test]
fn the_header_is_that_of_the_code() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).expect("its settings");
    let made = cbindgen::Builder::new().with_config(config).with_src_dirs(folder);
    let mut text = Vec::new();
    made.generate().expect("a header").write(&mut text);
    // What a caller promises stands in the sentences of the library's own manual.
    let text = String::from_utf8(text).expect("text").replace("# Safety", "@pre");
    let path = folder.join("include/throng.h");
    if std::env::var_os("UPDATE_HEADER").is_some() {
        std::fs::write(&path, &text).expect("written");
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(kept == text, "{} is not that of the code; run with UPDATE_HEADER=1", path.display());
}

trait Sources {
    fn with_src_dirs(self, folder: &Path) -> Self;
}

impl Sources for cbindgen::Builder {
    /// Every source file, in the order in which readers meet them.
    fn with_src_dirs(self, folder: &Path) -> Self {
        const ORDER: [&str; 8] = ["fault", "tables", "stage", "scene", "people", "layout", "read", "instances"];
        let exports = |file: &Path| std::fs::read_to_string(file).is_ok_and(|text| text.contains("extern \"C\" fn"));
        for file in std::fs::read_dir(folder.join("src")).expect("sources").map(|file| file.expect("a file").path()) {
            let is_listed = ORDER.iter().any(|name| file.file_stem().is_some_and(|stem| stem == *name));
            assert!(
                is_listed || !exports(&file),
                "{}: name it here, or the header lacks its functions",
                file.display()
            );
        }
        ORDER.iter().fold(self, |builder, name| builder.with_src(folder.join(format!("src/{name}.rs"))))
    }
}
