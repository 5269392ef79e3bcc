//! Writes clips for eyes and tools outside: tables of joint positions.

use crate::raw::RawClip;
use std::io::{self, Write};

/// Writes the world position of every joint in every frame as CSV: `frame,joint,x,y,z`, metres, Y up.
///
/// Frames count from 0; joints have their names in the source, ends of chains `PARENT_end`. A name that holds a
/// comma, quote or line end is quoted.
///
/// # Errors
/// Whatever `out` fails with.
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

fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}
