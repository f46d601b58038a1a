//! The coordinates in which laws are searched for.

/// One coordinate of the search for a base law. In the order in which the search takes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Coordinate {
    /// Force of a branch at the reference compression, N; the equilibrium is branch 0.
    Force(usize),
    /// Force of all branches together, N, where the shares are given.
    Total,
    /// Shape of the elastic response: the exponent q of the power law.
    Shape,
    /// Logarithm of the rate, 1/s, of a branch with a state of the reference compression.
    Rate(usize),
    /// Order β of a kernel.
    Order,
    /// Power n of the state that its rate of change follows.
    Power,
    /// Damping, N·s/mm.
    Damping,
}
