//! Whether there is room for what is about to be allocated.
//!
//! Allocating itself ends the program when there is none. What may be large is therefore asked for first.

use std::fmt;
use std::hint::black_box;

/// There is no memory for what was to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoRoom {
    /// Bytes that were asked for.
    pub bytes: u64,
}

impl fmt::Display for NoRoom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "there is not enough memory: {} MB are needed", self.bytes.div_ceil(1_000_000))
    }
}

impl std::error::Error for NoRoom {}

/// Asks for room for pieces of that many bytes each, all at the same time, and gives it back.
///
/// # Errors
/// There is none.
///
/// # Cost
/// No page is touched; the system may promise more than there is, as it does for sparse fields.
pub fn probe(pieces: impl IntoIterator<Item = u64>) -> Result<(), NoRoom> {
    let pieces: Vec<u64> = pieces.into_iter().collect();
    let no_room = || NoRoom { bytes: pieces.iter().fold(0, |sum, &bytes| sum.saturating_add(bytes)) };
    let mut held = Vec::new();
    for &bytes in &pieces {
        let mut piece: Vec<u8> = Vec::new();
        let bytes = usize::try_from(bytes).map_err(|_| no_room())?;
        piece.try_reserve_exact(bytes).map_err(|_| no_room())?;
        held.push(piece);
    }
    // Room that nobody uses would not be asked for.
    black_box(&held);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pieces_have_room_and_impossible_ones_do_not() {
        assert_eq!(probe([0, 1, 4096]), Ok(()));
        assert_eq!(probe([1, u64::MAX]), Err(NoRoom { bytes: u64::MAX }));
        assert_eq!(probe([1 << 62, 1 << 61]), Err(NoRoom { bytes: 3 << 61 }));
    }
}
