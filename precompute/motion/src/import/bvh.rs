//! Reads BVH: a HIERARCHY of joints with offsets and channels, then MOTION with one line of numbers per frame.
//!
//! Rotations apply in channel order (the first channel is the outermost), whatever order each joint chooses.
//! Position channels replace the joint's offset, axis by axis, on any joint.

use super::scan::{Scanner, text};
use super::source::{CoordinateAxis, FrameSink, MAX_JOINTS, MAX_NAME, SourceClip, content_error, duplicate_names};
use crate::error::{ImportError, ensure};
use crate::raw::{RawJoint, SourceFormat};
use glam::Vec3;
use std::path::Path;

const HELP_HIERARCHY: &str = "The file is cut short or damaged: export the clip again.";
const HELP_MOTION: &str = "Every frame is one line with one number per channel: export the clip again.";

/// A number of a frame, with the joint and the axis that it moves.
struct BvhChannel {
    joint: usize,
    axis: CoordinateAxis,
    rotates: bool,
}

struct Hierarchy {
    joints: Vec<RawJoint>,
    channels: Vec<BvhChannel>,
    /// The joint whose block is open.
    open: Option<usize>,
}

/// Reads a clip from the text of a BVH file; `path` is for errors and the clip's name.
///
/// Memory is in proportion to the text, whatever counts it contains.
///
/// # Errors
/// [`ImportError::Syntax`] with line and column, [`ImportError::Content`] where there is no motion.
pub fn parse(bytes: &[u8], path: &Path) -> Result<SourceClip, ImportError> {
    let mut scan = Scanner::new(bytes, path)?;
    let hierarchy = read_hierarchy(&mut scan)?;
    let num_frames = read_frame_count(&mut scan)?;
    let (rate_hz, finding) = read_frame_time(&mut scan)?;
    let mut warnings = duplicate_names(&hierarchy.joints, path);
    let frames = read_frames(&mut scan, hierarchy, num_frames)?;
    let read = frames.num_frames();
    if read as u64 != num_frames {
        let (path, rows) = (path.display(), if read as u64 > num_frames { "one row more" } else { "one row less" });
        warnings.push(format!("{path}: it has {rows} than the {num_frames} of `Frames:`; {read} are read."));
    }
    let clip = frames.into_clip(path, SourceFormat::Bvh, rate_hz);
    Ok(SourceClip { clip, declared_metres_per_unit: None, findings: vec![finding], warnings })
}

fn read_hierarchy(scan: &mut Scanner) -> Result<Hierarchy, ImportError> {
    scan.expect("HIERARCHY", "This is not a BVH file: it must start with HIERARCHY.")?;
    let mut h = Hierarchy { joints: Vec::new(), channels: Vec::new(), open: None };
    loop {
        scan.skip_space();
        let mark = scan.position();
        let word = scan.word().unwrap_or_default();
        let is = |keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
        match h.open {
            None if is("ROOT") => open_joint(scan, &mut h)?,
            None if is("MOTION") && !h.joints.is_empty() => return Ok(h),
            None => {
                let expected = if h.joints.is_empty() { "`ROOT`" } else { "`ROOT` or `MOTION`" };
                return Err(scan.error(mark, expected, HELP_HIERARCHY));
            }
            Some(_) if is("JOINT") => open_joint(scan, &mut h)?,
            Some(joint) if is("OFFSET") => h.joints[joint].offset = read_offset(scan)?,
            Some(joint) if is("CHANNELS") => read_channels(scan, joint, &mut h.channels)?,
            Some(joint) if is("End") => read_end_site(scan, joint, &mut h.joints)?,
            Some(joint) if is("}") => h.open = h.joints[joint].parent,
            Some(_) => {
                return Err(scan.error(mark, "`OFFSET`, `CHANNELS`, `JOINT`, `End Site` or `}`", HELP_HIERARCHY));
            }
        }
        let expected = || format!("at most {MAX_JOINTS} joints");
        ensure(h.joints.len() <= MAX_JOINTS, || scan.error_found(mark, &expected(), "one more", HELP_HIERARCHY))?;
    }
}

fn open_joint(scan: &mut Scanner, h: &mut Hierarchy) -> Result<(), ImportError> {
    let mark = scan.next_position();
    let name = scan.name();
    ensure(!name.is_empty(), || scan.error(mark, "the name of a joint", HELP_HIERARCHY))?;
    let expected = format!("a name of at most {MAX_NAME} bytes");
    ensure(name.len() <= MAX_NAME, || scan.error(mark, &expected, "Give the joint a shorter name."))?;
    scan.expect("{", HELP_HIERARCHY)?;
    let parent = h.open.replace(h.joints.len());
    h.joints.push(RawJoint::new(text(name), parent, Vec3::ZERO, false));
    Ok(())
}

fn read_offset(scan: &mut Scanner) -> Result<Vec3, ImportError> {
    let mut offset = [0.0; 3];
    for (value, axis) in offset.iter_mut().zip(["x", "y", "z"]) {
        *value = scan.number(&format!("the {axis} of an offset"), HELP_HIERARCHY)? as f32;
    }
    Ok(Vec3::from(offset))
}

fn read_channels(scan: &mut Scanner, joint: usize, channels: &mut Vec<BvhChannel>) -> Result<(), ImportError> {
    let mark = scan.next_position();
    let first = channels.len();
    let count = scan.count("a number of channels", HELP_HIERARCHY)?;
    ensure(count <= 6, || scan.error(mark, "at most 6 channels", "A joint has three positions and three rotations."))?;
    for _ in 0..count {
        scan.skip_space();
        let mark = scan.position();
        let channel = scan.word().and_then(|w| channel_of(w, joint));
        let Some(channel) = channel else {
            let expected = "a channel: Xposition, Yposition, Zposition, Xrotation, Yrotation or Zrotation";
            return Err(scan.error(mark, expected, "The number after CHANNELS says how many names follow."));
        };
        if channels[first..].iter().any(|c| c.rotates == channel.rotates && c.axis == channel.axis && !c.rotates) {
            return Err(scan.error(mark, "each position channel once", HELP_HIERARCHY));
        }
        channels.push(channel);
    }
    Ok(())
}

fn channel_of(word: &[u8], joint: usize) -> Option<BvhChannel> {
    let (letter, kind) = word.split_first()?;
    let rotates = kind.eq_ignore_ascii_case(b"rotation");
    let known = rotates || kind.eq_ignore_ascii_case(b"position");
    CoordinateAxis::from_letter(*letter).filter(|_| known).map(|axis| BvhChannel { joint, axis, rotates })
}

fn read_end_site(scan: &mut Scanner, parent: usize, joints: &mut Vec<RawJoint>) -> Result<(), ImportError> {
    scan.name();
    scan.expect("{", HELP_HIERARCHY)?;
    scan.expect("OFFSET", HELP_HIERARCHY)?;
    let offset = read_offset(scan)?;
    scan.expect("}", HELP_HIERARCHY)?;
    let siblings = joints.iter().filter(|j| j.is_end && j.parent == Some(parent)).count();
    let number = if siblings == 0 { String::new() } else { (siblings + 1).to_string() };
    let name = format!("{}_end{number}", joints[parent].name);
    joints.push(RawJoint::new(name, Some(parent), offset, true));
    Ok(())
}

fn read_frame_count(scan: &mut Scanner) -> Result<u64, ImportError> {
    scan.expect("Frames", HELP_HIERARCHY)?;
    scan.expect(":", HELP_HIERARCHY)?;
    let mark = scan.next_position();
    match scan.count("the number of frames", HELP_HIERARCHY)? {
        0 => Err(scan.error(mark, "at least one frame", "A clip without motion cannot be used.")),
        n => Ok(n),
    }
}

fn read_frame_time(scan: &mut Scanner) -> Result<(f64, String), ImportError> {
    scan.expect("Frame", HELP_HIERARCHY)?;
    scan.expect("Time", HELP_HIERARCHY)?;
    scan.expect(":", HELP_HIERARCHY)?;
    let mark = scan.next_position();
    let seconds = scan.number("the seconds of a frame", HELP_HIERARCHY)?;
    let help = "Frame Time is in seconds: 0.0333333 at 30 Hz.";
    ensure((1e-5..=10.0).contains(&seconds), || scan.error(mark, "seconds between 0.00001 and 10", help))?;
    scan.rewind(mark);
    let written = text(scan.word().unwrap_or_default());
    scan.expect_line_end("nothing more on this line", HELP_HIERARCHY)?;
    let rate_hz = rate_of(seconds, &written);
    Ok((rate_hz, format!("{rate_hz} frames a second: the file says `Frame Time: {written}`.")))
}

/// The rate behind a frame time: a whole number where the written digits allow it.
fn rate_of(seconds: f64, written: &str) -> f64 {
    let (mantissa, exponent) = written.split_once(['e', 'E']).unwrap_or((written, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len().min(300)) as i32;
    let digit = 10f64.powi(exponent.parse::<i32>().unwrap_or(0).clamp(-300, 0) - decimals);
    let tolerance = (digit / seconds).clamp(1e-9, 0.005);
    let exact = 1.0 / seconds;
    let whole = exact.round();
    if whole >= 1.0 && (exact - whole).abs() <= whole * tolerance { whole } else { exact }
}

fn read_frames(scan: &mut Scanner, h: Hierarchy, num_frames: u64) -> Result<FrameSink, ImportError> {
    let mut sink = FrameSink::of_text(h.joints, scan);
    let num_channels = h.channels.len();
    let (path, help) = (scan.path, "A clip without motion cannot be used");
    ensure(num_channels > 0, || content_error(path, "no joint has a channel", help))?;
    let mut frame = 0;
    while scan.skip_space() {
        if frame > num_frames {
            let expected = format!("the end of the file after {num_frames} frames");
            return Err(scan.error(scan.position(), &expected, "Correct the number after `Frames:`."));
        }
        frame += 1;
        let expected = |what: &str| format!("{what} of frame {frame} of {num_frames}");
        sink.begin_frame();
        for (k, channel) in h.channels.iter().enumerate() {
            let of_channel = |e| with_expectation(e, expected(&format!("number {} of {num_channels}", k + 1)));
            channel.apply(scan.number("", "").map_err(of_channel)?, &mut sink);
        }
        scan.expect_line_end(&format!("{num_channels} numbers, one per channel"), HELP_MOTION)?;
        let is_small = sink.end_frame();
        let message = || format!("{} joints without channels of their own make too large a clip", sink.joints.len());
        ensure(is_small, || content_error(scan.path, message(), "Remove the joints that do not move"))?;
    }
    // Writers count the first or the last frame twice, or not at all.
    let expected = || format!("the line of frame {} of {num_frames}", frame + 1);
    let is_whole = frame + 1 >= num_frames && frame > 0;
    ensure(is_whole, || scan.error(scan.position(), &expected(), HELP_MOTION))?;
    Ok(sink)
}

fn with_expectation(error: ImportError, what: String) -> ImportError {
    match error {
        ImportError::Syntax { path, line, column, found, .. } => {
            ImportError::Syntax { path, line, column, found, expected: what, help: HELP_MOTION.into() }
        }
        other => other,
    }
}

impl BvhChannel {
    fn apply(&self, value: f64, sink: &mut FrameSink) {
        if self.rotates {
            let r = &mut sink.rotations[self.joint];
            *r *= self.axis.rotation(value.to_radians());
        } else {
            sink.translations[self.joint][self.axis as usize] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_no_longer_than_names_are() {
        let parse = |length: usize| {
            let joint = format!("ROOT {} {{ OFFSET 0 0 0 CHANNELS 1 Xposition }}", "n".repeat(length));
            parse(format!("HIERARCHY {joint} MOTION\nFrames: 1\nFrame Time: 0.1\n0\n").as_bytes(), Path::new("a.bvh"))
        };
        assert!(parse(MAX_NAME).is_ok());
        let e = parse(MAX_NAME + 1).unwrap_err().to_string();
        assert!(e.starts_with("a.bvh:1:16: expected a name of at most 1024 bytes, found `nnn") && e.len() < 200, "{e}");
    }

    #[test]
    fn a_row_more_or_less_than_was_announced_is_read_with_a_warning() {
        let parse = |announced: usize| {
            let text = "HIERARCHY ROOT a { OFFSET 0 0 0 CHANNELS 1 Xposition } MOTION\nFrames: ";
            parse(format!("{text}{announced}\nFrame Time: 0.1\n0\n1\n2\n").as_bytes(), Path::new("a.bvh"))
        };
        let read =
            |announced| parse(announced).map(|s| (s.clip.num_frames, s.warnings.messages)).map_err(|e| e.to_string());
        assert_eq!(read(3), Ok((3, Vec::new())));
        let more = "a.bvh: it has one row more than the 2 of `Frames:`; 3 are read.".to_owned();
        assert_eq!(read(2), Ok((3, vec![more])));
        let less = "a.bvh: it has one row less than the 4 of `Frames:`; 3 are read.".to_owned();
        assert_eq!(read(4), Ok((3, vec![less])));
        assert!(read(1).unwrap_err().contains("expected the end of the file after 1 frames"));
        assert!(read(5).unwrap_err().contains("expected the line of frame 4 of 5"));
    }

    #[test]
    fn rates_follow_the_digits_that_were_written() {
        let exact = 1.0 / 0.0333667;
        for (written, rate) in [
            ("0.0333333", 30.0),
            ("0.033333", 30.0),
            (".008333", 120.0),
            ("0.0083", 120.0),
            ("0.0333667", exact),
            ("0.016667", 60.0),
            ("0.0166666", 60.0),
            ("1.0", 1.0),
            ("3.33333333e-2", 30.0),
        ] {
            let got = rate_of(written.parse().unwrap(), written);
            assert!((got - rate).abs() < 1e-6 * rate, "{written}: {got}");
        }
    }
}
