//! Pace of a segment: at its own rate, slowing to a stand, starting from a stand, in place, or idling.

/// Played at its own rate.
pub const NORMAL: u32 = 0;
/// Ever more slowly, in twice its time; one is held at its end.
pub const SLOWING: u32 = 1;
/// Accelerates from a hold, over twice its time.
pub const STARTING: u32 = 2;
/// The last frame is held.
pub const HELD_STILL: u32 = 3;
/// Played at its own rate, but the root stays at its final place.
pub const IN_PLACE: u32 = 4;
/// Played nearly at its own rate, which each character has of its own.
pub const IDLING: u32 = 5;

/// Frame at a time since the segment began (both in frames; 0 to 2 `length` where its pace changes).
pub fn frame_at_time(pace: u32, length: f32, time: f32) -> f32 {
    let by_square = |t: f32| t * t / (4.0 * length);
    match pace {
        _ if !(pace == SLOWING || pace == STARTING) => time,
        // From there on the rest of a step is played at its own rate.
        _ if time >= 2.0 * length => time - length,
        SLOWING => length - by_square(2.0 * length - time),
        _ => by_square(time),
    }
}

/// Time since the segment began at a frame: the inverse of [`frame_at_time`] (both in frames).
pub fn time_at_frame(pace: u32, length: f32, frame: f32) -> f32 {
    let by_root = |f: f32| 2.0 * (length * f.max(0.0)).sqrt();
    match pace {
        _ if !(pace == SLOWING || pace == STARTING) => frame,
        _ if frame >= length => frame + length,
        SLOWING => 2.0 * length - by_root(length - frame),
        _ => by_root(frame),
    }
}

/// Frame some time after another frame (both in frames, `passed` >= 0).
pub fn frame_after(pace: u32, length: f32, from: f32, passed: f32) -> f32 {
    let to = frame_at_time(pace, length, time_at_frame(pace, length, from) + passed);
    // No number lies between this frame and the stand: with short steps it would never reach its end.
    if pace == SLOWING && passed > 0.0 && to <= from { length.max(from) } else { to }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slowing_ends_with_steps_of_any_length() {
        // Frames at 30 to 240 Hz, and steps at 1000 to 10 000 Hz.
        for (length, passed) in [(20.0, 0.003), (20.0, 0.03), (120.0, 0.015), (240.0, 0.03), (480.0, 0.024)] {
            let (mut at, mut steps) = (0.0, 0u32);
            while at < length {
                let next = frame_after(SLOWING, length, at, passed);
                assert!(next > at, "it stands at frame {at} of {length}");
                (at, steps) = (next, steps + 1);
            }
            let took = f64::from(steps) * f64::from(passed) / f64::from(length);
            assert!((took - 2.0).abs() < 0.02, "{took} times its length");
        }
    }

    #[test]
    fn segments_take_twice_their_time_and_meet_rest_at_one_end() {
        for pace in [SLOWING, STARTING] {
            for i in 0..=60 {
                let t = i as f32;
                assert!((time_at_frame(pace, 20.0, frame_at_time(pace, 20.0, t)) - t).abs() < 1e-3, "{pace} {t}");
            }
            assert_eq!([frame_at_time(pace, 20.0, 0.0), frame_at_time(pace, 20.0, 40.0)], [0.0, 20.0]);
        }
        let rate = |pace, t: f32| frame_at_time(pace, 20.0, t + 0.5) - frame_at_time(pace, 20.0, t - 0.5);
        assert!(rate(SLOWING, 39.0) < 0.06 && rate(SLOWING, 1.0) > 0.94);
        assert!(rate(STARTING, 1.0) < 0.06 && rate(STARTING, 39.0) > 0.94);
    }
}
