//! Plans motion of limbs in time with everything that moves.

pub mod ik;
pub mod limits;
pub mod linkage;
pub mod rotation;
pub mod shape;
