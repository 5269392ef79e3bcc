//! `throng run --serve`: a client reads the whole run; what is not for this machine alone is refused.

use super::{failed, refused};
use std::io::{BufRead, BufReader, Read};
use std::net::TcpStream;
use std::process::{Command, Stdio};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data/scenes/square.toml");

#[test]
fn a_scene_is_served_to_its_end() {
    let mut served = Command::new(env!("CARGO_BIN_EXE_throng"))
        .args(["run", SCENE, "--serve", "127.0.0.1:0", "--seconds", "0.5"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the command line starts");
    let mut out = BufReader::new(served.stdout.take().expect("its output"));
    let mut line = String::new();
    out.read_line(&mut line).expect("a line");
    let address = line.split(&[' ', ';'][..]).find(|word| word.starts_with("127.0.0.1:")).expect("an address");
    let mut bytes = Vec::new();
    let mut stream = TcpStream::connect(address).expect("it listens");
    stream.read_to_end(&mut bytes).expect("all messages");
    assert!(served.wait().expect("it ends").success());
    line.clear();
    out.read_to_string(&mut line).expect("text");
    assert!(line.starts_with("31 frames for 1 client(s)"), "{line}");
    let kinds = |kind: &[u8]| bytes.windows(kind.len()).filter(|w| *w == kind).count();
    // Short texts of MessagePack begin with 0xa0 and their length.
    assert_eq!((kinds(b"\xa4kind\xa5hello"), kinds(b"\xa4kind\xa3end")), (1, 1));
    assert!((1..=31).contains(&kinds(b"\xa4kind\xa5frame")));
}

#[test]
fn what_cannot_be_served_is_refused() {
    let e = failed(&["run", SCENE, "--serve", "0.0.0.0:0"]);
    assert!(e.contains("127.0.0.1:0") && e.contains("--serve-anyone"), "{e}");
    let e = failed(&["run", "a.throng", "--serve"]);
    assert!(e.contains("--serve") && e.contains("for scenes"), "{e}");
    assert!(refused(&["run", SCENE, "--serve", "here"]).contains("here"));
    assert!(refused(&["run", SCENE, "--speed", "2"]).contains("--serve"));
    assert!(refused(&["run", SCENE, "--json", "--serve"]).contains("--json"));
}
