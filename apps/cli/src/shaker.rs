//! What the commands for campaigns on the shaker share.

pub(crate) mod inputs;
pub(crate) mod runs;
