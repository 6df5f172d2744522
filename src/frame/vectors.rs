//! Loops over pixels, compiled for the widest vectors the machine has.

/// Runs `work` compiled for the widest vectors of this machine. It has to be `#[inline(always)]`, and what it calls too.
#[inline(always)]
pub(crate) fn widest<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
