//! Serves a running scene to programs that show it: a socket gives every client roots, poses and events, step by step.
//!
//! A single thread serves all clients. Each client has at most one message in flight and misses the messages that follow
//! until it is sent, so that slow or lost clients cost neither time nor memory.

mod message;

use crate::run::{ObservedStep, play_scene};
use std::io::{ErrorKind, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use throng_core::base::limits::{LIVE_SPEED, SECONDS, STEP_HZ};
use throng_motion::error::{BuildError, Result};
use throng_motion::progress::StopRequested;
use throng_simulation::{CompiledScene, Simulation};

/// Most clients at a time; further ones are refused, unless one of these no longer reads.
const MAX_CLIENTS: usize = 16;
/// Frames in a row from which a client that has missed them makes room for a new one.
const IDLE_FRAMES: u64 = 60;
/// Time between two polls of the sockets (s).
const POLL_S: f64 = 0.001;
/// Time that clients have at the end to receive the last messages (s).
const FAREWELL_S: f64 = 2.0;

/// How a scene is served.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveConfig {
    /// Simulated time; that of the scene where `None` (s, 0.001 to 100000).
    pub seconds: Option<f64>,
    /// Steps, and frames that are sent, a simulated second (Hz, 1 to 10000).
    pub step_hz: f64,
    /// Simulated seconds a second of wall time; 0 is as fast as possible (0 to 1000).
    pub speed: f64,
}

impl Default for LiveConfig {
    fn default() -> Self {
        Self { seconds: None, step_hz: 60.0, speed: 1.0 }
    }
}

/// Outcome of serving a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiveReport {
    /// Steps that were offered to clients.
    pub frames: usize,
    /// Clients that connected.
    pub clients: usize,
    /// Frames that clients missed because they were slow.
    pub missed_frames: usize,
}

/// A socket at which clients connect.
pub struct SceneServer(TcpListener);

fn serve_error(message: String, help: &str) -> BuildError {
    BuildError::Stage { stage: "serve", message, help: help.into() }
}

impl SceneServer {
    /// Opens a socket; port 0 stands for any free one.
    ///
    /// - `to_anyone`: allows addresses that others in the network can reach.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for such an address without that, and for one that is taken.
    pub fn bind(address: SocketAddr, to_anyone: bool) -> Result<Self> {
        if !address.ip().is_loopback() && !to_anyone {
            let what = format!("{address}: expected an address of this machine alone, such as 127.0.0.1:0");
            let help = "Others in the network could see the scene: give --serve-anyone if they may";
            return Err(serve_error(what, help));
        }
        let listener = TcpListener::bind(address).and_then(|l| l.set_nonblocking(true).map(|()| l));
        let listener = listener.map_err(|e| serve_error(format!("{address}: {e}"), "Choose another port; 0 is any"))?;
        Ok(Self(listener))
    }

    /// Address at which clients connect.
    ///
    /// # Errors
    /// [`BuildError::Stage`] with the message of the system.
    pub fn address(&self) -> Result<SocketAddr> {
        self.0.local_addr().map_err(|e| serve_error(e.to_string(), "Choose another address"))
    }

    /// Waits for the first client, and runs a scene to its end, or until `stop` is set.
    ///
    /// # Errors
    /// As [`Simulation::new`] and [`Simulation::step`], or [`BuildError::Stage`] for a config out of range.
    pub fn serve(&self, scene: &CompiledScene, config: &LiveConfig, stop: &AtomicBool) -> Result<LiveReport> {
        let (seconds, hz) = (config.seconds.unwrap_or(scene.scene().seconds), config.step_hz);
        SECONDS.check("seconds", None, seconds)?;
        STEP_HZ.check("step_hz", None, hz)?;
        LIVE_SPEED.check("speed", None, config.speed)?;
        let mut sim = Simulation::new(scene)?;
        let hello = Arc::new(checked_message(message::hello_message(&sim, hz))?);
        let mut clients = LiveClients { listener: &self.0, hello, all: Vec::new(), report: LiveReport::default() };
        while clients.all.is_empty() && !stop.load(Ordering::Relaxed) {
            clients.accept_and_push();
            std::thread::sleep(Duration::from_secs_f64(POLL_S));
        }
        let begin = Instant::now();
        let played = play_scene(&mut sim, seconds, hz, seconds, |sim, ObservedStep { step, .. }| {
            let due_s = if config.speed > 0.0 { sim.time_s() / config.speed } else { 0.0 };
            loop {
                if stop.load(Ordering::Relaxed) {
                    return Err(StopRequested.into());
                }
                clients.accept_and_push();
                let left_s = due_s - begin.elapsed().as_secs_f64();
                if left_s <= 0.0 {
                    break;
                }
                std::thread::sleep(Duration::from_secs_f64(left_s.min(POLL_S)));
            }
            clients.send_frame(&Arc::new(checked_message(message::frame_message(sim, step))?));
            Ok(())
        });
        match played {
            Ok(_) | Err(BuildError::Stopped(_)) => clients.end_stream(),
            Err(e) => Err(e),
        }
    }
}

fn checked_message(message: std::io::Result<Vec<u8>>) -> Result<Vec<u8>> {
    message.map_err(|e| serve_error(format!("a message of more than 4 GB: {e}"), "Serve fewer characters"))
}

/// All connected clients.
struct LiveClients<'a> {
    listener: &'a TcpListener,
    hello: Arc<Vec<u8>>,
    all: Vec<LiveClient>,
    report: LiveReport,
}

struct LiveClient {
    stream: TcpStream,
    /// The message in flight, and how much of it is sent (bytes).
    message: Arc<Vec<u8>>,
    num_sent: usize,
    /// Frames in a row that it has missed.
    missed: u64,
}

impl LiveClients<'_> {
    /// Accepts new clients, and continues to send messages in flight.
    fn accept_and_push(&mut self) {
        while let Ok((stream, _)) = self.listener.accept() {
            let is_ready = stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true)).is_ok();
            if self.all.len() >= MAX_CLIENTS {
                // Clients that no longer read make room.
                self.all.sort_by_key(|c| c.missed);
                self.all.truncate(self.all.partition_point(|c| c.missed < IDLE_FRAMES).max(MAX_CLIENTS - 1));
            }
            if is_ready && self.all.len() < MAX_CLIENTS {
                self.report.clients += 1;
                self.all.push(LiveClient { stream, message: Arc::clone(&self.hello), num_sent: 0, missed: 0 });
            }
        }
        self.all.retain_mut(|c| c.push_bytes());
    }

    /// Queues a frame for all clients that have received the previous message.
    fn send_frame(&mut self, frame: &Arc<Vec<u8>>) {
        self.report.frames += 1;
        for client in &mut self.all {
            if client.has_sent_all() {
                (client.message, client.num_sent, client.missed) = (Arc::clone(frame), 0, 0);
            } else {
                client.missed += 1;
                self.report.missed_frames += 1;
            }
        }
        self.all.retain_mut(|c| c.push_bytes());
    }

    /// Sends the end message to all clients that receive the rest in time.
    fn end_stream(mut self) -> Result<LiveReport> {
        let (begin, end) = (Instant::now(), Arc::new(checked_message(message::end_message())?));
        let has_end = |c: &LiveClient| Arc::ptr_eq(&c.message, &end) && c.has_sent_all();
        while self.all.iter().any(|c| !has_end(c)) && begin.elapsed().as_secs_f64() < FAREWELL_S {
            for client in self.all.iter_mut().filter(|c| c.has_sent_all() && !Arc::ptr_eq(&c.message, &end)) {
                (client.message, client.num_sent) = (Arc::clone(&end), 0);
            }
            self.all.retain_mut(|c| c.push_bytes());
            std::thread::sleep(Duration::from_secs_f64(POLL_S));
        }
        Ok(self.report)
    }
}

impl LiveClient {
    fn has_sent_all(&self) -> bool {
        self.num_sent == self.message.len()
    }

    /// Sends as much as the socket takes at once; false if the client is gone.
    fn push_bytes(&mut self) -> bool {
        while !self.has_sent_all() {
            match self.stream.write(&self.message[self.num_sent..]) {
                Ok(0) => return false,
                Ok(bytes) => self.num_sent += bytes,
                Err(e) if e.kind() == ErrorKind::WouldBlock => return true,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(_) => return false,
            }
        }
        true
    }
}

#[cfg(test)]
mod tests;
