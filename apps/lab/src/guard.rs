//! What every block must hold before anything is made of it.

use crate::device::{Block, Identity};
use crate::ending::Ending;

/// Looks at the blocks of one device, in their order.
#[derive(Debug, Default)]
pub struct Guard {
    due: Option<u64>,
}

impl Guard {
    /// Forgets the counter: the device begins anew.
    pub fn restart(&mut self) {
        self.due = None;
    }

    /// Refuses a block that cannot be.
    ///
    /// # Errors
    /// A wrong number of channels or samples, a counter that jumps, a sample that is no number.
    pub fn check(&mut self, block: &Block, identity: &Identity) -> Result<(), Ending> {
        let wanted = identity.block;
        let odd = block.channels.iter().find(|c| c.len() != wanted);
        if odd.is_some() || block.channels.len() != identity.channels.len() {
            self.due = None;
            return Err(Ending::ShortBlock {
                got: odd.map_or(0, Vec::len),
                wanted,
            });
        }
        let due = self.due.replace(block.first.wrapping_add(wanted as u64));
        if let Some(due) = due.filter(|due| *due != block.first) {
            return Err(Ending::Counter {
                due,
                got: block.first,
            });
        }
        for (channel, name) in block.channels.iter().zip(&identity.channels) {
            if let Some(at) = channel.iter().position(|v| !v.is_finite()) {
                return Err(Ending::NotANumber {
                    channel: name.clone(),
                    sample: block.first + at as u64,
                });
            }
        }
        Ok(())
    }

    /// The channel beyond its full scale, if one is.
    pub fn overload(block: &Block, identity: &Identity) -> Option<Ending> {
        // The last code of a converter is a little below its full scale.
        let limit = identity.full_scale * (1.0 - 1e-6);
        let beyond = |c: &Vec<f64>| c.iter().any(|v| v.abs() >= limit);
        let told = block.overloaded.first().copied();
        let found = told.or_else(|| block.channels.iter().position(beyond))?;
        let channel = identity.channels.get(found);
        Some(Ending::Overload {
            channel: channel.map_or_else(|| (found + 1).to_string(), Clone::clone),
        })
    }
}
