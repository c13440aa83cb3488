//! Families of shapes with identities and poses, generated from a seed.
