//! Reads AMC: the numbers that move the joints of an ASF skeleton, one line per joint, one block per frame.

use super::{Asf, AsfJoint, Dof, FrameSink, Scanner, SourceClip, TextPosition, content_error, parse_count, text};
use crate::error::{ImportError, Warnings, ensure};
use crate::raw::SourceFormat;
use glam::{DQuat, DVec3};
use std::{collections::HashMap, path::Path};
use throng_base::text::did_you_mean;

const HELP: &str = "The file is cut short or damaged: compare it with an intact copy.";
/// Rate of files that name none: the CMU database was captured at 120 Hz and its files do not say so.
const DEFAULT_RATE_HZ: f64 = 120.0;

/// A frame while its lines are read.
struct AmcFrame {
    number: u64,
    mark: TextPosition,
    /// Frame in which each joint was last given, from 1 (joints.len()).
    given: Vec<u64>,
    count: usize,
    index: u64,
}

/// Reads a clip from the text of an AMC file that moves the skeleton `asf`.
///
/// Memory is in proportion to the text.
///
/// # Errors
/// [`ImportError::Syntax`] with line and column; frames must be complete and numbered without gaps.
pub fn parse(bytes: &[u8], path: &Path, asf: &Asf) -> Result<SourceClip, ImportError> {
    let mut scan = Scanner::new(bytes, path)?;
    let (named_rate, degrees) = read_header(&mut scan, asf)?;
    let frames = read_frames(&mut scan, asf, degrees)?;
    let rate_finding = match named_rate {
        Some(rate) => format!("{rate} frames a second: the file says so (`:SAMPLES-PER-SECOND`)."),
        None => format!(
            "{DEFAULT_RATE_HZ} frames a second: the file names no rate, and files that name none come from the CMU \
             database, captured at that rate (`--rate-hz`, or `import.rate_hz`, overrides it)."
        ),
    };
    let rate_hz = named_rate.unwrap_or(DEFAULT_RATE_HZ);
    Ok(SourceClip {
        clip: frames.into_clip(path, SourceFormat::AsfAmc, rate_hz),
        declared_metres_per_unit: Some(asf.metres_per_unit),
        findings: vec![format!("Skeleton: {}.", asf.path.display()), rate_finding],
        warnings: Warnings::default(),
    })
}

/// Reads comments and keywords up to the first frame number: the rate, if they name one (Hz), and whether angles are degrees.
fn read_header(scan: &mut Scanner, asf: &Asf) -> Result<(Option<f64>, bool), ImportError> {
    let (mut rate_hz, mut degrees) = (None, asf.degrees);
    while scan.skip_space() {
        let mark = scan.position();
        let word = scan.word().unwrap_or_default();
        let is = |keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
        if is(":SAMPLES-PER-SECOND") {
            let mark = scan.next_position();
            let rate = scan.number("the frames a second", HELP)?;
            ensure((0.1..=100_000.0).contains(&rate), || scan.error(mark, "a rate between 0.1 and 100000 Hz", HELP))?;
            rate_hz = Some(rate);
        } else if is(":DEGREES") || is(":RADIANS") {
            degrees = is(":DEGREES");
        } else if !word.starts_with(b":") && !word.starts_with(b"#") {
            scan.rewind(mark);
            break;
        }
        scan.next_line();
    }
    Ok((rate_hz, degrees))
}

fn read_frames(scan: &mut Scanner, asf: &Asf, degrees: bool) -> Result<FrameSink, ImportError> {
    let mut sink = FrameSink::of_text(asf.joints.clone(), scan);
    let by_name: HashMap<&[u8], usize> =
        asf.joints.iter().enumerate().filter(|(_, j)| !j.is_end).map(|(i, j)| (j.name.as_bytes(), i)).collect();
    let scale = if degrees { 1f64.to_radians() } else { 1.0 };
    let mut block: Option<AmcFrame> = None;
    // Lines come in the same order in every frame: the joint expected next is tried before the map.
    let mut order: Vec<usize> = Vec::new();
    while scan.skip_space() {
        let mark = scan.position();
        let word = scan.word().unwrap_or_default();
        if word.starts_with(b"#") {
            scan.next_line();
            continue;
        }
        if word[0].is_ascii_digit() && scan.at_line_end() {
            let number = frame_number(scan, mark, block.as_ref())?;
            let (given, index) = match block.take() {
                None => (vec![0; asf.joints.len()], 1),
                Some(previous) => {
                    previous.finish(scan, asf, &mut sink)?;
                    (previous.given, previous.index + 1)
                }
            };
            sink.begin_frame();
            block = Some(AmcFrame { number, mark, given, count: 0, index });
            continue;
        }
        let b = block.as_mut().ok_or_else(|| scan.error(mark, "the number of the first frame", HELP))?;
        let guess = order.get(b.count).copied().filter(|&j| asf.joints[j].name.as_bytes() == word);
        let joint = guess.or_else(|| by_name.get(word).copied());
        let joint = joint.ok_or_else(|| unknown_joint(scan, mark, word, asf))?;
        if b.index == 1 {
            order.push(joint);
        }
        b.take_joint(scan, mark, joint)?;
        let detail = &asf.details[joint];
        let (t, r) = read_joint(scan, detail, scale)?;
        let root = sink.joints[joint].parent.is_none();
        sink.translations[joint] += if root { t } else { detail.axis * t };
        sink.rotations[joint] = detail.axis * r * detail.axis.conjugate();
    }
    match block {
        Some(b) => b.finish(scan, asf, &mut sink)?,
        None => return Err(scan.error(scan.position(), "at least one frame", HELP)),
    }
    Ok(sink)
}

/// Reads the number of a frame, which follows that of the previous one.
fn frame_number(scan: &Scanner, mark: TextPosition, previous: Option<&AmcFrame>) -> Result<u64, ImportError> {
    let mut here = scan.cursor_at(mark);
    let number = here.word().and_then(parse_count).ok_or_else(|| scan.error(mark, "a frame number", HELP))?;
    if let Some(p) = previous.filter(|p| p.number.checked_add(1) != Some(number)) {
        let help = "Frames are missing or out of order: restore them, or number them without gaps.";
        return Err(scan.error(mark, &format!("frame {}", p.number.saturating_add(1)), help));
    }
    Ok(number)
}

impl AmcFrame {
    fn take_joint(&mut self, scan: &Scanner, mark: TextPosition, joint: usize) -> Result<(), ImportError> {
        let expected = || format!("each joint once in frame {}", self.number);
        ensure(self.given[joint] != self.index, || scan.error(mark, &expected(), HELP))?;
        self.given[joint] = self.index;
        self.count += 1;
        Ok(())
    }

    /// Checks that every joint that can move was given, and keeps the frame.
    fn finish(&self, scan: &Scanner, asf: &Asf, sink: &mut FrameSink) -> Result<(), ImportError> {
        let missing = |(j, d): (usize, &AsfJoint)| !d.dofs.is_empty() && self.given[j] != self.index;
        if let Some((j, _)) = asf.details.iter().enumerate().find(|&p| missing(p)) {
            let expected = format!("a line for `{}` in frame {}", asf.joints[j].name, self.number);
            return Err(scan.error_found(self.mark, &expected, "a frame without it", HELP));
        }
        if !sink.end_frame() {
            let message = "its skeleton has too many joints that never move";
            return Err(content_error(scan.path, message, "Check that the ASF file belongs to this AMC file"));
        }
        Ok(())
    }
}

/// Reads the translation and the rotation of a joint along its axes.
fn read_joint(scan: &mut Scanner, detail: &AsfJoint, scale: f64) -> Result<(DVec3, DQuat), ImportError> {
    let (mut t, mut r) = (DVec3::ZERO, DQuat::IDENTITY);
    for dof in &detail.dofs {
        let mark = scan.position();
        let value = scan.number("", "").map_err(|_| wrong_count(scan, mark, detail))?;
        match dof {
            Dof::Translate(axis) => t[*axis as usize] = value,
            Dof::Rotate(axis) => r = axis.rotation(value * scale) * r,
        }
    }
    ensure(scan.at_line_end(), || wrong_count(scan, scan.position(), detail))?;
    Ok((t, r))
}

#[cold]
fn wrong_count(scan: &Scanner, mark: TextPosition, detail: &AsfJoint) -> ImportError {
    let mut here = scan.cursor_at(mark);
    here.at_line_end();
    let n = detail.dofs.len();
    let help = "The ASF file lists the numbers of each joint (`dof`): check that it belongs to this AMC file.";
    scan.error(here.position(), &format!("{n} number{} on this line", if n == 1 { "" } else { "s" }), help)
}

#[cold]
fn unknown_joint(scan: &Scanner, mark: TextPosition, word: &[u8], asf: &Asf) -> ImportError {
    let meant = did_you_mean(&text(word), asf.joints.iter().filter(|j| !j.is_end).map(|j| j.name.as_str()));
    let help =
        format!("{} has no such joint.{meant} Name the right skeleton with `asf` in the config.", asf.path.display());
    scan.error(mark, "a frame number or the name of a joint", &help)
}
