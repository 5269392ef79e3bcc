//! Hits as rows, from clips and from bundles, for reports, pictures and other programs.

use crate::clip::{Clip, ClipSet};
use crate::export::quoted;
use glam::Vec3;
use std::io::{self, Write};
use throng_core::{Bundle, Joint};

/// A hit and its clip.
#[derive(Clone, Debug, PartialEq)]
pub struct HitPoint {
    /// Name of its clip.
    pub clip: String,
    /// Frame within the clip.
    pub frame: usize,
    /// Time since the clip's first frame (s).
    pub time_s: f64,
    /// Name of its kind.
    pub kind: String,
    /// The joint that strikes.
    pub joint: Joint,
    /// Effective hitting point, relative to the frame's planar root (m).
    pub position: Vec3,
    /// Direction of its motion, relative to the planar root (unit).
    pub direction: Vec3,
    /// Speed (m/s).
    pub speed_mps: f32,
    /// Speed over that of the fastest hit of its kind in the set (> 0, <= 1).
    pub force: f32,
}

impl HitPoint {
    /// All hits of a set, mirrored copies included.
    pub fn from_clip_set(set: &ClipSet) -> Vec<Self> {
        set.clips.iter().flat_map(Self::from_clip).collect()
    }

    /// The hits of a clip.
    pub fn from_clip(clip: &Clip) -> Vec<Self> {
        let point = |h: &crate::clip::ClipHit| Self {
            clip: clip.name.clone(),
            frame: h.frame,
            time_s: h.frame as f64 / clip.rate_hz,
            kind: h.kind.name().to_owned(),
            joint: h.joint,
            position: h.position,
            direction: h.direction,
            speed_mps: h.speed_mps,
            force: h.force,
        };
        clip.hits.iter().map(point).collect()
    }

    /// All hits of a bundle.
    pub fn from_bundle(tables: &Bundle) -> Vec<Self> {
        let (meta, clips) = (tables.meta(), tables.clips());
        let kinds: Vec<&str> = meta.hit_kinds().collect();
        let point = |h: &throng_core::HitRecord| {
            // Opening a bundle has checked that every hit has a clip, a kind and a joint.
            let clip = clips.partition_point(|c| c.first_frame <= h.frame) - 1;
            let frame = (h.frame - clips[clip].first_frame) as usize;
            Self {
                clip: meta.clips[clip].name.clone(),
                frame,
                time_s: frame as f64 / meta.rate_hz,
                kind: kinds[h.kind as usize].to_owned(),
                joint: Joint::ALL[h.joint as usize],
                position: h.position(),
                direction: h.direction(),
                speed_mps: h.speed_mps,
                force: h.force,
            }
        };
        tables.hits().iter().map(point).collect()
    }

    /// Angle from straight ahead, positive to the left (rad).
    pub fn angle(&self) -> f32 {
        self.position.x.atan2(self.position.z)
    }

    /// Distance over the ground (m).
    pub fn distance(&self) -> f32 {
        self.position.x.hypot(self.position.z)
    }
}

/// Writes hits as CSV: clip, frame, time, kind, joint, point and direction as seen from the planar root (+X left, Y up,
/// +Z ahead), speed and force.
///
/// # Errors
/// Errors of `out`.
pub fn write_csv(points: &[HitPoint], out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    writeln!(out, "clip,frame,time_s,kind,joint,x_m,y_m,z_m,dir_x,dir_y,dir_z,speed_mps,force")?;
    for h in points {
        let HitPoint { frame, time_s, joint, position: p, direction: d, speed_mps, force, .. } = h;
        let numbers = [p.x, p.y, p.z, d.x, d.y, d.z].map(|v| format!("{v:.4}")).join(",");
        let (clip, kind, joint) = (quoted(&h.clip), quoted(&h.kind), joint.name());
        writeln!(out, "{clip},{frame},{time_s:.4},{kind},{joint},{numbers},{speed_mps:.3},{force:.4}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_as_many_fields_as_the_header() {
        let point = HitPoint {
            clip: "a".into(),
            frame: 45,
            time_s: 1.5,
            kind: "head butt".into(),
            joint: Joint::Head,
            position: Vec3::new(0.3, 1.6, 0.4),
            direction: Vec3::Z,
            speed_mps: 3.25,
            force: 0.5,
        };
        assert!((point.distance() - 0.5).abs() < 1e-6 && (point.angle() - 0.3f32.atan2(0.4)).abs() < 1e-6);
        let mut csv = Vec::new();
        write_csv(&[point], &mut csv).unwrap();
        let csv = String::from_utf8(csv).unwrap();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines[0].split(',').count(), lines[1].split(',').count());
        assert_eq!(lines[1], "a,45,1.5000,head butt,head,0.3000,1.6000,0.4000,0.0000,0.0000,1.0000,3.250,0.5000");
    }
}
