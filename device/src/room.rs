//! What a device borrows because it is too large to be moved over a stack.

use crate::blocks::Blocks;
use crate::felt::Feeling;

/// 2 KB that a device works in.
#[derive(Clone, Debug, Default)]
pub struct Room {
    pub(crate) blocks: Blocks,
    pub(crate) feeling: Feeling,
}

impl Room {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self { blocks: Blocks::new(), feeling: Feeling::new() }
    }
}
