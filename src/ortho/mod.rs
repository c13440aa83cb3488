//! Gram-Schmidt in an M-inner product, blocked, with rank detection.
