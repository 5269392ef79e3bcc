//! Routes of agents: orders, routes, prepared routes, and paths round obstacles.

pub(crate) mod goals;
pub(crate) mod guide;
pub(crate) mod order;
pub(crate) mod outline;
pub(crate) mod passages;
pub(crate) mod path;
pub(crate) mod route;
pub(crate) mod streets;
