//! What a page calls. One page, one thread, one stage.

use crate::stage::Stage;
use glam::Vec2;
use std::cell::RefCell;

/// All that there is.
#[derive(Default)]
struct Page {
    stage: Option<Stage>,
    /// Bytes that the page wrote.
    input: Vec<u8>,
    /// Why the last call failed.
    text: String,
    /// Numbers that were asked for.
    numbers: Vec<f32>,
    parents: Vec<i32>,
    /// How many elements the last pointer has.
    size: usize,
}

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
}

impl Page {
    /// Notes why a call failed.
    fn said(&mut self, result: Result<(), String>) -> u32 {
        match result {
            Ok(()) => 0,
            Err(why) => {
                self.text = why;
                1
            }
        }
    }

    fn with_stage(&mut self, work: impl FnOnce(&mut Stage) -> Result<(), String>) -> u32 {
        let result = match &mut self.stage {
            Some(stage) => work(stage),
            None => Err("no bundle is open; call throng_open".into()),
        };
        self.said(result)
    }

    /// Where a slice lies; its length is kept for [`throng_size`].
    fn slice<T>(&mut self, of: impl FnOnce(&mut Self) -> &[T]) -> *const T {
        let slice = of(self);
        let (at, size) = (slice.as_ptr(), slice.len());
        self.size = size;
        at
    }
}

fn on<R>(work: impl FnOnce(&mut Page) -> R) -> R {
    PAGE.with(|page| work(&mut page.borrow_mut()))
}

/// Room for so many bytes, for [`throng_open`].
#[unsafe(no_mangle)]
pub extern "C" fn throng_input(bytes: usize) -> *mut u8 {
    on(|page| {
        page.input = vec![0; bytes];
        page.input.as_mut_ptr()
    })
}

/// Opens the bundle that was written to [`throng_input`]; nobody is there yet. Where it fails, what was open stays.
#[unsafe(no_mangle)]
pub extern "C" fn throng_open() -> u32 {
    on(|page| {
        let bytes = std::mem::take(&mut page.input);
        let opened = Stage::open(&bytes).map(|stage| page.stage = Some(stage));
        page.said(opened)
    })
}

/// Lets so many people walk to targets.
#[unsafe(no_mangle)]
pub extern "C" fn throng_people(count: u32, seed: u32) -> u32 {
    on(|page| page.with_stage(|s| s.people(count as usize, seed.into()).map_err(|e| e.to_string())))
}

/// Lets so many agents cross a square.
#[unsafe(no_mangle)]
pub extern "C" fn throng_agents(count: u32, seed: u32) -> u32 {
    on(|page| page.with_stage(|s| s.agents(count as usize, seed.into()).map_err(|e| e.to_string())))
}

/// Moves everybody on (s).
#[unsafe(no_mangle)]
pub extern "C" fn throng_step(dt_s: f32) -> u32 {
    on(|page| page.with_stage(|s| s.step(dt_s)))
}

/// Moves a target (m); without a number that there is, nothing.
#[unsafe(no_mangle)]
pub extern "C" fn throng_target(number: u32, x: f32, z: f32) -> u32 {
    on(|page| page.with_stage(|s| s.move_target(number as usize, Vec2::new(x, z)).map_err(|e| e.to_string())))
}

/// Places of targets, x and z (m); see [`throng_size`] for how many numbers.
#[unsafe(no_mangle)]
pub extern "C" fn throng_targets() -> *const f32 {
    on(|page| {
        page.numbers = page.stage.iter().flat_map(|s| s.targets()).flat_map(|t| [t.x, t.y]).collect();
        page.slice(|page| &page.numbers)
    })
}

/// The records, 32 bytes each; [`throng_size`] is their number.
#[unsafe(no_mangle)]
pub extern "C" fn throng_records() -> *const u8 {
    on(|page| page.slice(|page| page.stage.as_ref().map_or(&[], |s| &s.records[..]))).cast()
}

/// Poses of all frame rows, 22 times 12 numbers each.
#[unsafe(no_mangle)]
pub extern "C" fn throng_rows() -> *const f32 {
    on(|page| page.slice(|page| page.stage.as_ref().map_or(&[], |s| bytemuck::cast_slice(&s.rows))))
}

/// Joints at rest, three numbers each (m).
#[unsafe(no_mangle)]
pub extern "C" fn throng_rest() -> *const f32 {
    on(|page| {
        page.numbers = page.stage.iter().flat_map(|s| s.rest()).flat_map(|p| p.to_array()).collect();
        page.slice(|page| &page.numbers)
    })
}

/// Numbers of joints' parents.
#[unsafe(no_mangle)]
pub extern "C" fn throng_parents() -> *const i32 {
    on(|page| {
        page.parents = Stage::parents().to_vec();
        page.slice(|page| &page.parents)
    })
}

/// Why the last call failed, UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn throng_text() -> *const u8 {
    on(|page| page.slice(|page| page.text.as_bytes()))
}

/// How many elements lie at the pointer that was returned last.
#[unsafe(no_mangle)]
pub extern "C" fn throng_size() -> usize {
    on(|page| page.size)
}
