//! Work on threads of their own, so that the window keeps drawing.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A value that is made on its own thread.
#[derive(Debug)]
pub struct Background<T>(pub(super) Receiver<T>);

impl<T: Send + 'static> Background<T> {
    /// Starts to make a value.
    ///
    /// - `wake`: called when it is done, unless the value is no longer wanted.
    pub fn start(make: impl FnOnce() -> T + Send + 'static, wake: impl FnOnce() + Send + 'static) -> Self {
        let (send, made) = channel();
        std::thread::spawn(move || {
            // The receiver is gone if something else was asked for meanwhile.
            if send.send(make()).is_ok() {
                wake();
            }
        });
        Self(made)
    }

    /// The value, once it is made.
    ///
    /// - `waits`: blocks until then.
    /// - `lost`: value in place of one whose thread ended unexpectedly.
    pub fn poll(&self, waits: bool, lost: impl FnOnce() -> T) -> Option<T> {
        let made = if waits { self.0.recv().map_err(|_| TryRecvError::Disconnected) } else { self.0.try_recv() };
        match made {
            Err(TryRecvError::Empty) => None,
            made => Some(made.unwrap_or_else(|_| lost())),
        }
    }
}
