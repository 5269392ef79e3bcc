//! Four characters at a time: vectors of four floats, one lane a character, and what is built of them.
//!
//! On x86-64 an [`F4`] is one SSE2 register (SSE2 is part of the architecture's baseline, so there is no detection
//! and no second code path); elsewhere it is an array that the compiler vectorises. Only operations that IEEE 754
//! rounds the same way everywhere are used, so results are equal on every machine.

#[cfg(all(test, target_arch = "x86_64"))]
#[path = "array.rs"]
mod array;
mod quat;
#[cfg_attr(target_arch = "x86_64", path = "sse2.rs")]
#[cfg_attr(not(target_arch = "x86_64"), path = "array.rs")]
mod repr;
mod scalar;

pub(crate) use quat::{Q4, V4};
pub(crate) use repr::F4;

/// Number of lanes.
pub(crate) const LANES: usize = 4;

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::{F4, array};
    use proptest::prelude::*;

    fn four() -> impl Strategy<Value = [f32; 4]> {
        prop::array::uniform4(-100.0f32..100.0)
    }

    proptest! {
        #[test]
        fn registers_and_arrays_give_the_same_bits(a in four(), b in four(), s in 0.0f32..1.0) {
            let (x, y) = (F4::from_array(a), F4::from_array(b));
            let (p, q) = (array::F4::from_array(a), array::F4::from_array(b));
            prop_assert_eq!((x + y).to_array(), (p + q).to_array());
            prop_assert_eq!((x - y).to_array(), (p - q).to_array());
            prop_assert_eq!((x * y).to_array(), (p * q).to_array());
            prop_assert_eq!((x / y).to_array(), (p / q).to_array());
            prop_assert_eq!((-x).to_array(), (-p).to_array());
            prop_assert_eq!(x.min(y).to_array(), p.min(q).to_array());
            prop_assert_eq!(x.max(y).to_array(), p.max(q).to_array());
            prop_assert_eq!(x.abs().sqrt().to_array(), p.abs().sqrt().to_array());
            prop_assert_eq!(x.round().to_array(), p.round().to_array());
            prop_assert_eq!(
                F4::select_lt(x, y, x * F4::splat(s), y).to_array(),
                array::F4::select_lt(p, q, p * array::F4::splat(s), q).to_array()
            );
            prop_assert_eq!(x.any_gt(y), p.any_gt(q));
        }

        #[test]
        fn integers_are_decoded_alike(rows in prop::array::uniform4(prop::array::uniform4(any::<i16>()))) {
            let r = [&rows[0], &rows[1], &rows[2], &rows[3]];
            let x = F4::decode(r).map(F4::to_array);
            prop_assert_eq!(x, array::F4::decode(r).map(array::F4::to_array));
            prop_assert_eq!(x[2][1], f32::from(rows[1][2]));
        }

        #[test]
        fn transposes(a in four(), b in four(), c in four(), d in four()) {
            let m = [a, b, c, d];
            let t = F4::transpose(m.map(F4::from_array)).map(F4::to_array);
            for i in 0..4 { for j in 0..4 { prop_assert_eq!(t[i][j], m[j][i]); } }
            prop_assert_eq!(t, array::F4::transpose(m.map(array::F4::from_array)).map(array::F4::to_array));
        }
    }
}
