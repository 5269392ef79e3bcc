//! Clients of all manners.

use super::*;
use std::io::Read;
use std::path::Path;
use throng_core::{Bundle, Inline};
use throng_simulation::Scene;

const HZ: f64 = 60.0;

fn scene(count: usize, seconds: f64) -> CompiledScene {
    let golden = format!("../../data/golden/tables_v{}.throng", throng_core::format::VERSION);
    let bundle = Bundle::open(Path::new(env!("CARGO_MANIFEST_DIR")).join(golden)).expect("golden tables");
    let text = format!(
        "bundle = \"b.throng\"\nseconds = {seconds}\n[[groups]]\nmotion = \"blend\"\ncount = {count}\nspaces = [\"walks\"]\n\
         place = {{ block = {{ from = [-40.0, -40.0], to = [40.0, 40.0] }} }}\ngoal = {{ shift = {{ by = [8.0, 0.0] }} }}\n"
    );
    Scene::parse(&text, "live.toml".as_ref()).expect("a scene").compile(&bundle).expect("it compiles")
}

/// Serves a scene to clients that run on threads of their own, as fast as it goes.
fn served<T: Send>(
    scene: &CompiledScene,
    clients: Vec<Box<dyn FnOnce(TcpStream) -> T + Send>>,
) -> (LiveReport, Vec<T>) {
    let server = SceneServer::bind(([127, 0, 0, 1], 0).into(), false).expect("a free port");
    let address = server.address().expect("an address");
    // All are there before it begins.
    let streams: Vec<TcpStream> = clients.iter().map(|_| TcpStream::connect(address).expect("it listens")).collect();
    std::thread::scope(|scope| {
        let running: Vec<_> = clients.into_iter().zip(streams).map(|(c, s)| scope.spawn(move || c(s))).collect();
        let config = LiveConfig { speed: 0.0, ..LiveConfig::default() };
        let report = server.serve(scene, &config, &AtomicBool::new(false)).expect("it ends");
        (report, running.into_iter().map(|r| r.join().expect("a client ends")).collect())
    })
}

/// The next message; none at the end of the stream.
fn next(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).ok()?;
    let mut out = vec![0; u32::from_le_bytes(length) as usize];
    stream.read_exact(&mut out).expect("a whole message");
    Some(out)
}

/// Where the value of a key begins in a map whose other values hold no such text.
fn value<'a>(message: &'a [u8], key: &str) -> &'a [u8] {
    let at = message.windows(key.len()).position(|w| w == key.as_bytes()).expect("the key");
    &message[at + key.len()..]
}

fn bytes<'a>(message: &'a [u8], key: &str) -> &'a [u8] {
    let mut rest = value(message, key);
    let length = rmp::decode::read_bin_len(&mut rest).expect("bytes") as usize;
    &rest[..length]
}

fn numbers(message: &[u8], key: &str) -> Vec<u32> {
    bytes(message, key).as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect()
}

fn is(message: &[u8], kind: &str) -> bool {
    value(message, "kind")[1..].starts_with(kind.as_bytes())
}

/// Reads to the end; all messages.
fn read_all(mut stream: TcpStream) -> Vec<Vec<u8>> {
    std::iter::from_fn(|| next(&mut stream)).collect()
}

#[test]
fn a_client_reads_what_the_same_simulation_gives() {
    let scene = scene(5, 1.0);
    let (report, all) = served(&scene, vec![Box::new(read_all)]);
    assert_eq!((report.frames, report.clients), (61, 1));
    let messages = &all[0];
    assert!(is(&messages[0], "hello") && is(&messages[messages.len() - 1], "end"));
    let frames = &messages[1..messages.len() - 1];
    assert_eq!(frames.len() + report.missed_frames, report.frames);
    assert!(!frames.is_empty());

    let mut sim = Simulation::new(&scene).expect("it starts");
    let mut step = 0;
    for frame in frames {
        assert!(is(frame, "frame"));
        let wanted: usize = rmp::decode::read_int(&mut value(frame, "step")).expect("a number");
        while step < wanted {
            step += 1;
            sim.step_to(step as f64 / HZ, &Inline).expect("a step");
        }
        assert_eq!(numbers(frame, "ids"), [0, 1, 2, 3, 4]);
        let roots: Vec<u32> = sim.roots().flatten().flat_map(|r| [r.x, r.z, r.heading].map(f32::to_bits)).collect();
        assert_eq!(numbers(frame, "roots"), roots);
        let rows = sim.poses().flatten().flat_map(|pose| pose.iter().flat_map(|j| j.rows.as_flattened()).copied());
        assert_eq!(numbers(frame, "poses"), rows.map(f32::to_bits).collect::<Vec<_>>());
    }
}

#[test]
fn clients_that_are_slow_or_gone_or_talk_hold_nobody_up() {
    let scene = scene(400, 1.0);
    let hangs_up = |stream: TcpStream| {
        drop(stream);
        Vec::new()
    };
    let talks = |mut stream: TcpStream| {
        _ = stream.write_all(&[0xff; 4096]);
        read_all(stream)
    };
    // Takes the first message, and the rest only when all is over.
    let (over, is_over) = std::sync::mpsc::channel::<()>();
    let sleeps = move |mut stream: TcpStream| {
        let hello = next(&mut stream);
        _ = is_over.recv();
        hello.into_iter().collect()
    };
    let reads = move |stream| {
        let all = read_all(stream);
        drop(over);
        all
    };
    let (report, all) = served(&scene, vec![Box::new(hangs_up), Box::new(talks), Box::new(sleeps), Box::new(reads)]);
    assert_eq!((report.frames, report.clients), (61, 4));
    assert!(report.missed_frames > 0, "400 characters of 61 frames fit into no socket");
    assert!(is(all[3].last().expect("messages"), "end"));
    assert!(is(&all[2][0], "hello"));
}

/// As many clients as there may be, of which none reads, and one that comes late.
#[test]
fn clients_that_never_read_make_room() {
    let (scene, server) = (scene(400, 4.0), SceneServer::bind(([127, 0, 0, 1], 0).into(), false).expect("a free port"));
    let address = server.address().expect("an address");
    let idle: Vec<TcpStream> = (0..MAX_CLIENTS).map(|_| TcpStream::connect(address).expect("it listens")).collect();
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let late = scope.spawn(|| {
            let told = (0..200).find_map(|_| {
                std::thread::sleep(Duration::from_millis(20));
                TcpStream::connect(address).ok().and_then(|mut stream| next(&mut stream))
            });
            stop.store(true, Ordering::Relaxed);
            told
        });
        let config = LiveConfig { speed: 1.0, ..LiveConfig::default() };
        server.serve(&scene, &config, &stop).expect("it ends");
        assert!(is(&late.join().expect("a client ends").expect("a message"), "hello"));
    });
    drop(idle);
}

#[test]
fn it_ends_when_told_and_is_for_this_machine_alone() {
    let server = SceneServer::bind(([127, 0, 0, 1], 0).into(), false).expect("a free port");
    let report = server.serve(&scene(1, 1.0), &LiveConfig::default(), &AtomicBool::new(true));
    assert_eq!(report.expect("it ends"), LiveReport::default());
    let error = SceneServer::bind(([0, 0, 0, 0], 0).into(), false).map(|_| ()).expect_err("anybody could connect");
    assert!(error.to_string().contains("--serve-anyone"), "{error}");
    assert!(SceneServer::bind(([0, 0, 0, 0], 0).into(), true).is_ok());
    let config = LiveConfig { speed: -1.0, ..LiveConfig::default() };
    let error = server.serve(&scene(1, 1.0), &config, &AtomicBool::new(false)).expect_err("time goes forwards");
    assert!(error.to_string().contains("speed is -1, expected 0 to 1000"), "{error}");
}
