use std::sync::OnceLock;

#[cfg(any(target_arch = "aarch64", target_arch = "x86_64"))]
use super::isa::IsaLevel;

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

/// Returns the parts of [`VERSION`].
///
/// ```
/// use catamaran::base::{VERSION, version};
///
/// let found = version();
/// assert_eq!(VERSION, format!("{}.{}.{}", found.major, found.minor, found.patch));
/// ```
pub fn version() -> VersionNumber {
    let mut parts = VERSION.split('.').map(|p| p.parse().unwrap_or(0));
    let mut next = || parts.next().unwrap_or(0);
    VersionNumber { major: next(), minor: next(), patch: next() }
}

/// Returns the names of the instruction sets of this CPU that the kernels can use, as detected at
/// run time, up to the limit of this process ([`isa_limit`](super::isa_limit)).
///
/// ```
/// use catamaran::base::cpu_features;
///
/// let found = cpu_features();
/// assert!(found.contains(&"avx2") || !found.contains(&"avx512f"));
/// ```
pub fn cpu_features() -> Vec<&'static str> {
    #[allow(unused_mut)]
    let mut found = Vec::new();
    #[cfg(any(target_arch = "aarch64", target_arch = "x86_64"))]
    let mut add = |level: IsaLevel, detected, name| {
        if detected && level.permitted().is_ok() {
            found.push(name);
        }
    };
    #[cfg(target_arch = "aarch64")]
    {
        use std::arch::is_aarch64_feature_detected;
        add(IsaLevel::Neon, true, "neon");
        add(IsaLevel::Dotprod, is_aarch64_feature_detected!("dotprod"), "dotprod");
        add(IsaLevel::I8mm, is_aarch64_feature_detected!("i8mm"), "i8mm");
    }
    #[cfg(target_arch = "x86_64")]
    {
        add(IsaLevel::Avx2, is_x86_feature_detected!("avx2"), "avx2");
        add(IsaLevel::Avx2, is_x86_feature_detected!("fma"), "fma");
        add(IsaLevel::AvxVnni, is_x86_feature_detected!("avxvnni"), "avxvnni");
        add(IsaLevel::Avx512, is_x86_feature_detected!("avx512f"), "avx512f");
        add(IsaLevel::Vnni, is_x86_feature_detected!("avx512vnni"), "avx512vnni");
    }
    found
}

/// Returns the bytes of the first and second-level data caches of a core, or usual sizes where the
/// CPU does not report them.
pub(crate) fn data_caches() -> [usize; 2] {
    static CACHES: OnceLock<[usize; 2]> = OnceLock::new();
    *CACHES.get_or_init(|| [data_cache(1).unwrap_or(32 << 10), data_cache(2).unwrap_or(1 << 20)])
}

fn data_cache(level: u32) -> Option<usize> {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{__cpuid, __cpuid_count};
        // The deterministic cache parameters: Intel's leaf, then AMD's of the same form.
        for (limit, leaf) in [(0, 4), (0x8000_0000, 0x8000_001d)] {
            if __cpuid(limit).eax < leaf {
                continue;
            }
            for i in 0..8 {
                let found = __cpuid_count(leaf, i);
                const INSTRUCTIONS: u32 = 2;
                let kind = found.eax & 0x1f;
                if kind == 0 {
                    break;
                }
                if found.eax >> 5 & 0x7 == level && kind != INSTRUCTIONS {
                    let ways = (found.ebx >> 22) + 1;
                    let partitions = (found.ebx >> 12 & 0x3ff) + 1;
                    let line = (found.ebx & 0xfff) + 1;
                    let bytes = [ways, partitions, line, found.ecx + 1].map(|n| n as usize);
                    return Some(bytes.iter().product());
                }
            }
        }
        None
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        // As Linux describes the caches of a core, in KiB; other systems have no such files.
        (0..8).find_map(|i| {
            let read = |name: &str| {
                let path = format!("/sys/devices/system/cpu/cpu0/cache/index{i}/{name}");
                Some(std::fs::read_to_string(path).ok()?.trim().to_owned())
            };
            let wanted = read("level")? == level.to_string() && read("type")? != "Instruction";
            let size = wanted.then(|| read("size")).flatten()?;
            Some(size.strip_suffix('K')?.parse::<usize>().ok()? << 10)
        })
    }
}
