//! How long work tells how far it is.

/// Receives the progress of the stages. Calls may come from any thread.
pub trait Progress: Sync {
    /// A stage begins that has `total` units of work (0 where that is unknown), counted in `unit`.
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str);
    /// `done` more units are finished.
    fn advance(&self, done: u64);
    /// The stage is finished.
    fn end(&self);
    /// A build comes to a stage, which may say more of itself.
    fn comes_to(&self, _stage: &'static str) {}
    /// The output of a stage is kept: a build that is begun again goes on behind it.
    fn kept(&self, _stage: &'static str) {}
}

/// Reports nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &'static str, _: u64, _: &'static str) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
}
