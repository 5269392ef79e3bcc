//! Where agents go: orders, routes, the splines that agents follow, and ways round obstacles.

pub(crate) mod order;
pub(crate) mod outline;
pub(crate) mod route;
pub(crate) mod smooth;
pub(crate) mod spline;
pub(crate) mod streets;
