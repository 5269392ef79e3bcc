//! The viewer: everything that is baked, seen and tried. Its window is not built yet.

fn main() -> std::process::ExitCode {
    eprintln!("throng-viewer has no window yet; `throng demo` draws a picture of a crowd");
    std::process::ExitCode::FAILURE
}
