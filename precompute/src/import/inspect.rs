//! Says what was found in a clip, for people and for programs.

use super::Imported;
use crate::raw::SourceFormat;
use std::collections::BTreeMap;
use std::fmt;

/// What import found in a clip. The names of the fields are keys of the JSON report.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ClipReport {
    /// The file.
    pub file: String,
    /// `bvh` or `asf_amc`.
    pub format: &'static str,
    /// Number of joints, ends of chains included.
    pub joints: usize,
    /// Number of frames.
    pub frames: usize,
    /// Frames a second. [Unit: Hz]
    pub rate_hz: f64,
    /// Length of the clip. [Unit: s]
    pub duration_s: f64,
    /// Length of one unit of the file. [Unit: m]
    pub metres_per_unit: f64,
    /// Axis that points up in the file: `Y` or `Z`.
    pub up: char,
    /// `t_pose`, `a_pose` or `other`.
    pub rest_pose: &'static str,
    /// Heading the rest pose faces. [Unit: degrees]
    pub facing_deg: f32,
    /// Body height estimated from the lengths of the segments. [Unit: m]
    pub height_m: f32,
    /// Skeleton profile, or that roles were guessed.
    pub profile: String,
    /// Source joint of each role.
    pub roles: BTreeMap<&'static str, String>,
    /// What was detected and why.
    pub findings: Vec<String>,
    /// How the feet behave; filled in by whoever ran the later stages.
    pub contact: Option<ContactSanity>,
    /// What is odd but tolerable.
    pub warnings: Vec<String>,
}

/// How the feet of a clip behave once contacts are known: feet of a well-read walk are on the ground about 60 % of
/// the time and hardly move there.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ContactSanity {
    /// Share of frames in which the left foot is on the ground. [Limit: 0..=1]
    pub left_share: f32,
    /// Share of frames in which the right foot is on the ground. [Limit: 0..=1]
    pub right_share: f32,
    /// Mean speed of a foot while on the ground. [Unit: m/s]
    pub contact_speed_mps: f32,
}

impl ClipReport {
    /// Collects what is known of a clip.
    pub fn new(imported: &Imported) -> Self {
        let clip = &imported.clip;
        let roles = imported.roles.pairs(&clip.joints).map(|(role, joint)| (role.name(), joint.to_owned()));
        Self {
            file: clip.path.display().to_string(),
            format: match clip.format {
                SourceFormat::Bvh => "bvh",
                SourceFormat::AsfAmc => "asf_amc",
            },
            joints: clip.joints.len(),
            frames: clip.num_frames,
            rate_hz: clip.rate_hz,
            duration_s: clip.num_frames as f64 / clip.rate_hz,
            metres_per_unit: imported.metres_per_unit,
            up: imported.up.letter(),
            rest_pose: imported.rest_pose.kind.name(),
            facing_deg: imported.facing.to_degrees() + 0.0,
            height_m: imported.height,
            profile: imported.roles.profile.clone(),
            roles: roles.collect(),
            findings: imported.findings.clone(),
            contact: None,
            warnings: imported.warnings.messages.clone(),
        }
    }
}

impl fmt::Display for ClipReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.file)?;
        writeln!(f, "  format   {}, {} joints", self.format, self.joints)?;
        writeln!(f, "  motion   {} frames at {} Hz, {:.2} s", self.frames, self.rate_hz, self.duration_s)?;
        writeln!(f, "  body     {:.2} m tall, skeleton profile: {}", self.height_m, self.profile)?;
        writeln!(f, "  found")?;
        for finding in &self.findings {
            writeln!(f, "    {finding}")?;
        }
        writeln!(f, "  roles")?;
        for role in throng_runtime::Joint::ALL {
            let joint = self.roles.get(role.name()).map_or("-", String::as_str);
            writeln!(f, "    {:<16} {joint}", role.name())?;
        }
        if let Some(c) = &self.contact {
            let (left, right) = (100.0 * c.left_share, 100.0 * c.right_share);
            let speed = c.contact_speed_mps;
            writeln!(f, "  contact  left {left:.0} %, right {right:.0} %, foot speed on the ground {speed:.3} m/s")?;
        }
        for warning in &self.warnings {
            writeln!(f, "  warning  {warning}")?;
        }
        Ok(())
    }
}
