//! What pages of several jobs share.

pub(crate) mod coverage;
pub(crate) mod parameters;
