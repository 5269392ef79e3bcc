//! Reads ASF: the skeleton that AMC files move.
//!
//! Segments are given by direction and length in global axes; the joint of a segment is at its start, and the ends of chains
//! become `NAME_end` joints. So every rest rotation is the identity, and a segment's own `axis` C turns its motion R into
//! global axes: the joint rotates by C R C^-1.

use super::{CoordinateAxis, MAX_JOINTS, MAX_NAME, Scanner, TextPosition, text};
use crate::error::{ImportError, ensure};
use crate::raw::RawJoint;
use glam::{DQuat, DVec3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

const HELP: &str = "The file is damaged or not an ASF skeleton: compare it with an intact one.";
/// One inch; ASF lengths are inches divided by the `length` of `:units`.
const INCH: f64 = 0.0254;

/// A number that an AMC line holds for a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dof {
    Translate(CoordinateAxis),
    Rotate(CoordinateAxis),
}

/// Entry of an ASF file for one joint, beyond its place in the skeleton.
#[derive(Clone, Debug, Default)]
pub(super) struct AsfJoint {
    /// The numbers of its AMC line, in order. Rotations apply in this order, the first one innermost.
    pub dofs: Vec<Dof>,
    /// Rotation from the segment's own axes to the global ones.
    pub axis: DQuat,
}

/// The skeleton of an ASF file, in its own units.
#[derive(Clone, Debug)]
pub struct Asf {
    /// The file.
    pub path: PathBuf,
    /// Joints, parents first, each chain in one run.
    pub joints: Vec<RawJoint>,
    /// Length of one unit by the file's `:units` (m).
    pub metres_per_unit: f64,
    /// True where angles are in degrees, unless the AMC file says otherwise.
    pub degrees: bool,
    /// Entry of the file for each joint (joints.len()).
    pub(super) details: Vec<AsfJoint>,
}

/// A segment as written in `:bonedata`.
struct AsfSegment {
    name: String,
    mark: TextPosition,
    vector: DVec3,
    joint: AsfJoint,
    parent: Option<usize>,
    children: Vec<usize>,
}

impl AsfSegment {
    fn new(name: String, mark: TextPosition, vector: DVec3, joint: AsfJoint) -> Self {
        Self { name, mark, vector, joint, parent: None, children: Vec::new() }
    }
}

/// Everything that is read before the skeleton is put together; segment 0 is the root.
struct AsfReader<'a> {
    scan: Scanner<'a>,
    length: f64,
    degrees: bool,
    segments: Vec<AsfSegment>,
    by_name: HashMap<&'a [u8], usize>,
}

/// Reads a skeleton from the text of an ASF file.
///
/// # Errors
/// [`ImportError::Syntax`] with line and column.
pub fn parse(bytes: &[u8], path: &Path) -> Result<Asf, ImportError> {
    let scan = Scanner::new(bytes, path)?;
    let root = AsfSegment::new("root".into(), scan.position(), DVec3::ZERO, AsfJoint::default());
    let by_name = HashMap::from([(&b"root"[..], 0)]);
    let mut reader = AsfReader { scan, length: 1.0, degrees: true, segments: vec![root], by_name };
    let position = reader.read_sections()?;
    reader.assemble(position)
}

impl<'a> AsfReader<'a> {
    /// Reads all sections; returns the position of the root.
    fn read_sections(&mut self) -> Result<DVec3, ImportError> {
        let mut position = DVec3::ZERO;
        let mut seen = [false; 3];
        while self.scan.skip_space() {
            let mark = self.scan.position();
            let word = self.scan.word().unwrap_or_default();
            let is = |keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
            if is(":units") {
                self.scan.next_line();
                self.read_units()?;
            } else if is(":root") {
                self.scan.next_line();
                position = self.read_root()?;
                seen[0] = true;
            } else if is(":bonedata") {
                self.read_segments()?;
                seen[1] = true;
            } else if is(":hierarchy") {
                self.read_hierarchy()?;
                seen[2] = true;
            } else if word.starts_with(b":") || word.starts_with(b"#") {
                self.skip_section();
            } else {
                return Err(self.scan.error(mark, "a section such as `:root` or `:bonedata`", HELP));
            }
        }
        match seen.iter().zip([":root", ":bonedata", ":hierarchy"]).find(|(seen, _)| !**seen) {
            Some((_, section)) => Err(self.scan.error(self.scan.position(), &format!("a section `{section}`"), HELP)),
            None => Ok(position),
        }
    }

    /// Skips lines up to the next one that starts with a colon.
    fn skip_section(&mut self) {
        self.scan.next_line();
        while self.next_entry() {
            self.scan.next_line();
        }
    }

    /// Moves to the next line with text; false where a section starts or the file ends.
    fn next_entry(&mut self) -> bool {
        while self.scan.skip_space() {
            let mark = self.scan.position();
            let word = self.scan.word().unwrap_or_default();
            if word.starts_with(b"#") {
                self.scan.next_line();
                continue;
            }
            self.scan.rewind(mark);
            return !word.starts_with(b":");
        }
        false
    }

    fn read_units(&mut self) -> Result<(), ImportError> {
        while self.next_entry() {
            let word = self.scan.word().unwrap_or_default();
            if word.eq_ignore_ascii_case(b"length") {
                let mark = self.scan.next_position();
                self.length = self.scan.number("the length of a unit", HELP)?;
                ensure(self.length > 1e-9, || self.scan.error(mark, "a length above 0", HELP))?;
            } else if word.eq_ignore_ascii_case(b"angle") {
                let mark = self.scan.next_position();
                self.degrees = match self.scan.word().unwrap_or_default().to_ascii_lowercase().as_slice() {
                    b"deg" | b"degrees" => true,
                    b"rad" | b"radians" => false,
                    _ => return Err(self.scan.error(mark, "`deg` or `rad`", HELP)),
                };
            }
            self.scan.next_line();
        }
        Ok(())
    }

    fn read_root(&mut self) -> Result<DVec3, ImportError> {
        let (mut position, mut orientation, mut axis) =
            (DVec3::ZERO, [0.0; 3], [CoordinateAxis::X, CoordinateAxis::Y, CoordinateAxis::Z]);
        while self.next_entry() {
            let word = self.scan.word().unwrap_or_default().to_ascii_lowercase();
            match word.as_slice() {
                b"order" => self.segments[0].joint.dofs = self.read_dofs()?,
                b"axis" => axis = self.read_axis_order()?,
                b"position" => position = self.read_vector("the root's position")?,
                b"orientation" => orientation = self.read_vector("the root's orientation")?.to_array(),
                _ => {}
            }
            self.scan.next_line();
        }
        let missing = || self.scan.error(self.scan.position(), "`order` in section `:root`", HELP);
        ensure(!self.segments[0].joint.dofs.is_empty(), missing)?;
        self.segments[0].joint.axis = self.axis_rotation(orientation, axis);
        Ok(position)
    }

    fn read_segments(&mut self) -> Result<(), ImportError> {
        while self.next_entry() {
            self.scan.expect("begin", HELP)?;
            self.read_segment()?;
            let expected = format!("at most {MAX_JOINTS} segments");
            let too_many = || self.scan.error_found(self.scan.position(), &expected, "one more", HELP);
            ensure(self.segments.len() <= MAX_JOINTS, too_many)?;
        }
        Ok(())
    }

    fn read_segment(&mut self) -> Result<(), ImportError> {
        let mut name: Option<(&[u8], TextPosition)> = None;
        let (mut direction, mut length) = (None, None);
        let mut joint = AsfJoint::default();
        let end = loop {
            ensure(self.next_entry(), || self.scan.error(self.scan.position(), "`end` of the segment", HELP))?;
            let entry = self.scan.position();
            let word = self.scan.word().unwrap_or_default().to_ascii_lowercase();
            let mark = self.scan.next_position();
            match word.as_slice() {
                b"end" => break entry,
                b"name" => name = self.scan.word().map(|n| (n, mark)),
                b"direction" => direction = Some(self.read_vector("a direction")?),
                b"length" => length = Some(self.scan.number("a length", HELP)?),
                b"dof" => joint.dofs = self.read_dofs()?,
                b"axis" => {
                    let angles = self.read_vector("the angles of an axis")?.to_array();
                    let order = self.read_axis_order()?;
                    joint.axis = self.axis_rotation(angles, order);
                }
                b"begin" => return Err(self.scan.error(mark, "`end` before the next `begin`", HELP)),
                _ => {}
            }
            self.scan.next_line();
        };
        let missing = |what: &str| self.scan.error_found(end, what, "the segment's end without it", HELP);
        let (name, name_mark) = name.ok_or_else(|| missing("`name`"))?;
        let expected = || format!("a name of at most {MAX_NAME} bytes");
        ensure(name.len() <= MAX_NAME, || self.scan.error(name_mark, &expected(), "Give the segment a shorter name."))?;
        let direction = direction.ok_or_else(|| missing("`direction`"))?;
        let length = length.ok_or_else(|| missing("`length`"))?;
        let vector = direction.normalize_or_zero() * length;
        let is_new = self.by_name.insert(name, self.segments.len()).is_none();
        ensure(is_new, || self.scan.error(name_mark, "a name that no other segment has", HELP))?;
        self.segments.push(AsfSegment::new(text(name), name_mark, vector, joint));
        Ok(())
    }

    fn read_vector(&mut self, what: &str) -> Result<DVec3, ImportError> {
        let mut v = [0.0; 3];
        for value in &mut v {
            *value = self.scan.number(&format!("{what}, three numbers"), HELP)?;
        }
        Ok(DVec3::from(v))
    }

    fn read_axis_order(&mut self) -> Result<[CoordinateAxis; 3], ImportError> {
        let mark = self.scan.next_position();
        let word = self.scan.word().unwrap_or_default();
        let axes: Vec<_> = word.iter().take(4).map_while(|&b| CoordinateAxis::from_letter(b)).collect();
        match <[CoordinateAxis; 3]>::try_from(axes) {
            Ok(axes) if axes[0] != axes[1] && axes[1] != axes[2] && axes[0] != axes[2] => Ok(axes),
            _ => Err(self.scan.error(mark, "an axis order such as `XYZ`", HELP)),
        }
    }

    fn read_dofs(&mut self) -> Result<Vec<Dof>, ImportError> {
        let mut dofs = Vec::new();
        while !self.scan.at_line_end() {
            let mark = self.scan.position();
            let dof = match self.scan.word().unwrap_or_default() {
                [b't' | b'T', axis] => CoordinateAxis::from_letter(*axis).map(Dof::Translate),
                [b'r' | b'R', axis] => CoordinateAxis::from_letter(*axis).map(Dof::Rotate),
                _ => None,
            };
            match dof.filter(|d| !dofs.contains(d)) {
                Some(dof) => dofs.push(dof),
                None => {
                    let help = "Each may stand once; segments that change their length (`l`) are not read.";
                    return Err(self.scan.error(mark, "`tx`, `ty`, `tz`, `rx`, `ry` or `rz`", help));
                }
            }
        }
        Ok(dofs)
    }

    /// The rotation of three angles, the first one innermost.
    fn axis_rotation(&self, angles: [f64; 3], order: [CoordinateAxis; 3]) -> DQuat {
        let scale = if self.degrees { 1f64.to_radians() } else { 1.0 };
        order.iter().zip(angles).fold(DQuat::IDENTITY, |q, (axis, angle)| axis.rotation(angle * scale) * q)
    }

    fn read_hierarchy(&mut self) -> Result<(), ImportError> {
        while self.next_entry() {
            let line = self.scan.position();
            let first = self.scan.word().unwrap_or_default();
            if !first.eq_ignore_ascii_case(b"begin") && !first.eq_ignore_ascii_case(b"end") {
                self.scan.rewind(line);
                let parent = self.read_reference()?;
                while !self.scan.at_line_end() {
                    let mark = self.scan.position();
                    let child = self.read_reference()?;
                    let is_free = child > 0 && self.segments[child].parent.is_none();
                    ensure(is_free, || self.scan.error(mark, "a segment that has no parent yet", HELP))?;
                    self.segments[child].parent = Some(parent);
                    self.segments[parent].children.push(child);
                }
            }
            self.scan.next_line();
        }
        Ok(())
    }

    fn read_reference(&mut self) -> Result<usize, ImportError> {
        let mark = self.scan.next_position();
        let known = self.scan.word().and_then(|w| self.by_name.get(w).copied());
        known.ok_or_else(|| self.scan.error(mark, "the name of a segment in `:bonedata`, or `root`", HELP))
    }

    /// Joints in chain order from the root, with the ends of chains.
    fn assemble(self, position: DVec3) -> Result<Asf, ImportError> {
        let (path, metres_per_unit) = (self.scan.path.to_owned(), INCH / self.length);
        let mut asf = Asf { path, joints: Vec::new(), metres_per_unit, degrees: self.degrees, details: Vec::new() };
        let mut placed = vec![false; self.segments.len()];
        let mut stack = vec![(0, None)];
        while let Some((s, parent)) = stack.pop() {
            let segment = &self.segments[s];
            placed[s] = true;
            let offset = segment.parent.map_or(position, |p| self.segments[p].vector);
            let index = asf.push(segment.name.clone(), parent, offset, Some(segment.joint.clone()));
            if segment.children.is_empty() {
                asf.push(format!("{}_end", segment.name), Some(index), segment.vector, None);
            }
            stack.extend(segment.children.iter().rev().map(|&c| (c, Some(index))));
        }
        let Some(lost) = placed.iter().position(|p| !p).map(|s| &self.segments[s]) else { return Ok(asf) };
        let found = format!("`{}` without a way to the root", lost.name);
        Err(self.scan.error_found(lost.mark, "every segment in `:hierarchy`", &found, HELP))
    }
}

impl Asf {
    fn push(&mut self, name: String, parent: Option<usize>, offset: DVec3, joint: Option<AsfJoint>) -> usize {
        self.joints.push(RawJoint::new(name, parent, offset.as_vec3(), joint.is_none()));
        self.details.push(joint.unwrap_or_default());
        self.joints.len() - 1
    }
}
