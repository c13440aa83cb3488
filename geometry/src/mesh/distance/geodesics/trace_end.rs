/// How the trace of a geodesic ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TraceEnd {
    /// It has the length that was asked for.
    Complete,
    /// It stops at the boundary of the mesh.
    Boundary,
    /// It stops at an edge of more than two faces, or at a vertex where the surface meets itself:
    /// there is more than one way on.
    NonManifold,
}
