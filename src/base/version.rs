/// Version of this crate, `major.minor.patch`.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// A version number, part by part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VersionNumber {
    /// Major part.
    pub major: u32,
    /// Minor part.
    pub minor: u32,
    /// Patch part.
    pub patch: u32,
}

/// The parts of [`VERSION`].
pub fn version() -> VersionNumber {
    let mut parts = VERSION.split('.').map(|p| p.parse().unwrap_or(0));
    let mut next = || parts.next().unwrap_or(0);
    VersionNumber { major: next(), minor: next(), patch: next() }
}

/// The instruction sets of this CPU that matter here, as found at run time.
pub fn cpu_features() -> Vec<&'static str> {
    #[allow(unused_mut)]
    let mut found = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx2") {
            found.push("avx2");
        }
        if is_x86_feature_detected!("fma") {
            found.push("fma");
        }
        if is_x86_feature_detected!("avx512f") {
            found.push("avx512f");
        }
        if is_x86_feature_detected!("avx512vnni") {
            found.push("avx512vnni");
        }
    }
    found
}
