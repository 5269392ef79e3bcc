//! Writes clips for other tools: tables of joint positions.

use super::take::Take;
use crate::raw::RawClip;
use std::io::{self, Write};
use throng_core::Joint;

/// Writes the world position of every joint in every frame as CSV: `frame,joint,x,y,z`, metres, Y up.
///
/// Frames count from 0; joints have their names in the source, ends of chains `PARENT_end`. A name that holds a
/// comma, quote or line end is quoted.
///
/// # Errors
/// Errors of `out`.
pub fn positions_csv(clip: &RawClip, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let names: Vec<String> = clip.joints.iter().map(|j| quoted(&j.name)).collect();
    writeln!(out, "frame,joint,x,y,z")?;
    for frame in 0..clip.num_frames {
        for (name, (p, _)) in names.iter().zip(clip.world(frame)) {
            writeln!(out, "{frame},{name},{:.6},{:.6},{:.6}", p.x, p.y, p.z)?;
        }
    }
    Ok(())
}

/// Writes the world position of every joint of every actor of a take as CSV, actor by actor:
/// `character,time_s,joint,x_m,y_m,z_m`, Y up. Absent actors have no rows.
///
/// # Errors
/// Errors of `out`.
pub fn take_csv(take: &Take, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    writeln!(out, "character,time_s,joint,x_m,y_m,z_m")?;
    for (a, actor) in take.actors().iter().enumerate() {
        let name = if take.is_library() { quoted(&actor.name) } else { actor.number.to_string() };
        take.poses(a, |frame, pose, is_there| {
            let time_s = frame as f64 / take.rate_hz();
            for (joint, (p, _)) in Joint::ALL.iter().zip(pose.world_transforms()).filter(|_| is_there) {
                writeln!(out, "{name},{time_s:.6},{},{:.6},{:.6},{:.6}", joint.name(), p.x, p.y, p.z)?;
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// A name as a field of CSV.
pub fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}
