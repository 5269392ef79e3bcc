//! Functions that a page calls. There is one page, one thread and one stage.

use crate::stage::PageStage;
use glam::Vec2;
use std::cell::RefCell;

/// State of the page.
#[derive(Default)]
struct Page {
    stage: Option<PageStage>,
    /// Memory for bytes that the page writes.
    input: Vec<u8>,
    /// Reason why the last call failed.
    text: String,
    /// Numbers of the last request.
    numbers: Vec<f32>,
    parents: Vec<i32>,
    /// Number of elements at the last returned pointer.
    size: usize,
}

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
}

impl Page {
    /// Stores the reason of a failed call; returns the status.
    fn store_result(&mut self, result: Result<(), String>) -> u32 {
        let Err(why) = result else { return 0 };
        self.text = why;
        1
    }

    fn with_stage(&mut self, work: impl FnOnce(&mut PageStage) -> Result<(), String>) -> u32 {
        let none = || "no bundle is open; call throng_open".to_owned();
        let result = self.stage.as_mut().ok_or_else(none).and_then(work);
        self.store_result(result)
    }

    /// Pointer to a slice; its length is stored for [`throng_size`].
    fn publish_slice<T>(&mut self, of: impl FnOnce(&mut Self) -> &[T]) -> *const T {
        let slice = of(self);
        let (at, size) = (slice.as_ptr(), slice.len());
        self.size = size;
        at
    }
}

fn with_page<R>(work: impl FnOnce(&mut Page) -> R) -> R {
    PAGE.with(|page| work(&mut page.borrow_mut()))
}

/// Allocates memory for the bytes of a bundle, for [`throng_open`].
#[unsafe(no_mangle)]
pub extern "C" fn throng_input(bytes: usize) -> *mut u8 {
    with_page(|page| {
        page.input = vec![0; bytes];
        page.input.as_mut_ptr()
    })
}

/// Opens the bundle that was written to [`throng_input`], without characters. If it fails, the previous bundle stays open.
#[unsafe(no_mangle)]
pub extern "C" fn throng_open() -> u32 {
    with_page(|page| {
        let bytes = std::mem::take(&mut page.input);
        let opened = PageStage::open(&bytes).map(|stage| page.stage = Some(stage));
        page.store_result(opened)
    })
}

/// Places a number of people that walk to targets.
#[unsafe(no_mangle)]
pub extern "C" fn throng_people(count: u32, seed: u32) -> u32 {
    with_page(|page| page.with_stage(|s| s.spawn_people(count as usize, seed.into()).map_err(|e| e.to_string())))
}

/// Places a number of agents that cross a square.
#[unsafe(no_mangle)]
pub extern "C" fn throng_agents(count: u32, seed: u32) -> u32 {
    with_page(|page| page.with_stage(|s| s.spawn_agents(count as usize, seed.into()).map_err(|e| e.to_string())))
}

/// Steps the simulation by a duration (s).
#[unsafe(no_mangle)]
pub extern "C" fn throng_step(dt_s: f32) -> u32 {
    with_page(|page| page.with_stage(|s| s.step(dt_s)))
}

/// Moves a target (m); nothing happens for an unknown number.
#[unsafe(no_mangle)]
pub extern "C" fn throng_target(number: u32, x: f32, z: f32) -> u32 {
    with_page(|page| page.with_stage(|s| s.move_target(number as usize, Vec2::new(x, z)).map_err(|e| e.to_string())))
}

/// Positions of targets, x and z (m); [`throng_size`] is the count of numbers.
#[unsafe(no_mangle)]
pub extern "C" fn throng_targets() -> *const f32 {
    with_page(|page| {
        page.numbers = page.stage.iter().flat_map(|s| s.targets()).flat_map(|t| [t.x, t.y]).collect();
        page.publish_slice(|page| &page.numbers)
    })
}

/// Records of all characters, 32 bytes each; [`throng_size`] is their number.
#[unsafe(no_mangle)]
pub extern "C" fn throng_records() -> *const u8 {
    with_page(|page| page.publish_slice(|page| page.stage.as_ref().map_or(&[], |s| &s.records[..]))).cast()
}

/// Poses of all frame rows, 22 times 12 numbers each.
#[unsafe(no_mangle)]
pub extern "C" fn throng_rows() -> *const f32 {
    with_page(|page| page.publish_slice(|page| page.stage.as_ref().map_or(&[], |s| bytemuck::cast_slice(&s.rows))))
}

/// Positions of joints at rest, three numbers each (m).
#[unsafe(no_mangle)]
pub extern "C" fn throng_rest() -> *const f32 {
    with_page(|page| {
        page.numbers = page.stage.iter().flat_map(|s| s.rest_positions()).flat_map(|p| p.to_array()).collect();
        page.publish_slice(|page| &page.numbers)
    })
}

/// Number of each joint's parent.
#[unsafe(no_mangle)]
pub extern "C" fn throng_parents() -> *const i32 {
    with_page(|page| {
        page.parents = PageStage::joint_parents().to_vec();
        page.publish_slice(|page| &page.parents)
    })
}

/// Reason why the last call failed, in UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn throng_text() -> *const u8 {
    with_page(|page| page.publish_slice(|page| page.text.as_bytes()))
}

/// Number of elements at the pointer that was returned last.
#[unsafe(no_mangle)]
pub extern "C" fn throng_size() -> usize {
    with_page(|page| page.size)
}
