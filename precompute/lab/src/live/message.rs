//! Messages of a scene that is served: a length (4 bytes, little-endian) and a map in MessagePack.

use rmp::encode::{write_array_len, write_bin, write_f64, write_map_len, write_nil, write_sint, write_str, write_uint};
use std::io;
use throng_core::{Joint, NUM_JOINTS};
use throng_simulation::{CharacterEvent, Simulation, SimulationEvent};

/// Version of the messages.
const VERSION: u64 = 1;

/// First message: everything that does not change.
pub fn hello_message(sim: &Simulation, rate_hz: f64) -> io::Result<Vec<u8>> {
    encode_message("hello", 7, |out| {
        pair_uint(out, "version", VERSION)?;
        pair_f64(out, "rate_hz", rate_hz)?;
        pair_uint(out, "num_characters", sim.num_characters() as u64)?;
        write_str(out, "joints")?;
        write_array_len(out, NUM_JOINTS as u32)?;
        Joint::ALL.iter().try_for_each(|j| write_str(out, j.name()))?;
        write_str(out, "parents")?;
        write_array_len(out, NUM_JOINTS as u32)?;
        for j in Joint::ALL {
            write_sint(out, j.parent().map_or(-1, |p| p.index() as i64))?;
        }
        write_str(out, "groups")?;
        write_array_len(out, sim.groups().len() as u32)?;
        for group in sim.groups() {
            write_map_len(out, 5)?;
            pair_str(out, "name", &group.name)?;
            pair_str(out, "motion", group.motion.name())?;
            pair_uint(out, "first", group.characters.start as u64)?;
            pair_uint(out, "count", group.characters.len() as u64)?;
            if let Ok(bundle) = sim.compiled().bundle(group.number) {
                pair_floats(out, "offsets", bundle.skeleton().offsets.iter().flat_map(|o| o.to_array()))?;
            } else {
                write_str(out, "offsets")?;
                write_nil(out)?;
            }
        }
        Ok(())
    })
}

/// Message of one step.
pub fn frame_message(sim: &Simulation, step: usize) -> io::Result<Vec<u8>> {
    let there = || sim.roots().enumerate().filter_map(|(who, root)| Some((who, root?)));
    let posed = || sim.poses().enumerate().filter_map(|(who, pose)| Some((who, pose?)));
    encode_message("frame", 8, |out| {
        pair_uint(out, "step", step as u64)?;
        pair_f64(out, "time_s", sim.time_s())?;
        pair_integers(out, "ids", there().map(|(who, _)| who as u32))?;
        pair_floats(out, "roots", there().flat_map(|(_, r)| [r.x, r.z, r.heading]))?;
        pair_integers(out, "posed", posed().map(|(who, _)| who as u32))?;
        let rows = posed().flat_map(|(_, pose)| pose.iter().flat_map(|joint| joint.rows.as_flattened()).copied());
        pair_floats(out, "poses", rows)?;
        write_str(out, "events")?;
        write_array_len(out, sim.events().len() as u32)?;
        sim.events().iter().try_for_each(|e| write_event(out, e))
    })
}

/// Last message.
pub fn end_message() -> io::Result<Vec<u8>> {
    encode_message("end", 1, |_| Ok(()))
}

fn write_event(out: &mut Vec<u8>, event: &SimulationEvent) -> io::Result<()> {
    let (what, at, other) = match event.kind {
        CharacterEvent::Hit { at } => ("hit", Some(at), None),
        CharacterEvent::Struck { opponent, at, .. } => ("struck", Some(at), Some(opponent)),
        CharacterEvent::Fulfilled => ("fulfilled", None, None),
        CharacterEvent::Arrived => ("arrived", None, None),
        CharacterEvent::Left => ("left", None, None),
        CharacterEvent::Stuck => ("stuck", None, None),
        CharacterEvent::RunInto { obstacle } => ("run_into", None, Some(obstacle)),
    };
    write_map_len(out, 3 + u32::from(at.is_some()) + u32::from(other.is_some()))?;
    pair_f64(out, "time_s", event.time_s)?;
    pair_uint(out, "who", event.who as u64)?;
    pair_str(out, "what", what)?;
    if let Some(at) = at {
        pair_floats(out, "at", at.to_array())?;
    }
    other.map_or(Ok(()), |other| pair_uint(out, "other", other as u64))
}

/// Encodes a message of a kind, with `pairs` key-value pairs.
fn encode_message(kind: &str, pairs: u32, body: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> io::Result<Vec<u8>> {
    let mut out = vec![0; 4];
    write_map_len(&mut out, pairs)?;
    pair_str(&mut out, "kind", kind)?;
    body(&mut out)?;
    let length = u32::try_from(out.len() - 4).map_err(io::Error::other)?;
    out[..4].copy_from_slice(&length.to_le_bytes());
    Ok(out)
}

fn pair_str(out: &mut Vec<u8>, key: &str, value: &str) -> io::Result<()> {
    write_str(out, key)?;
    Ok(write_str(out, value)?)
}

fn pair_uint(out: &mut Vec<u8>, key: &str, value: u64) -> io::Result<()> {
    write_str(out, key)?;
    write_uint(out, value)?;
    Ok(())
}

fn pair_f64(out: &mut Vec<u8>, key: &str, value: f64) -> io::Result<()> {
    write_str(out, key)?;
    Ok(write_f64(out, value)?)
}

/// Writes numbers of 4 bytes each, little-endian.
fn pair_floats(out: &mut Vec<u8>, key: &str, numbers: impl IntoIterator<Item = f32>) -> io::Result<()> {
    write_str(out, key)?;
    Ok(write_bin(out, &numbers.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>())?)
}

/// Writes whole numbers of 4 bytes each, little-endian.
fn pair_integers(out: &mut Vec<u8>, key: &str, numbers: impl Iterator<Item = u32>) -> io::Result<()> {
    write_str(out, key)?;
    Ok(write_bin(out, &numbers.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())?)
}
