//! The name of this CPU.

/// Returns the brand name of the CPU and its signature (family, model and stepping), since
/// hypervisors give several models the same name, on one line; the architecture if the CPU has no
/// name.
pub(super) fn name() -> String {
    brand().unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

#[cfg(target_arch = "x86_64")]
fn brand() -> Option<String> {
    /// The cpuid leaves of the name, 16 bytes each.
    const BRAND: std::ops::RangeInclusive<u32> = 0x8000_0002..=0x8000_0004;
    let leaf = |leaf| {
        // SAFETY: every x86-64 CPU has the instruction, which reads no memory.
        #[allow(unused_unsafe)]
        unsafe {
            std::arch::x86_64::__cpuid(leaf)
        }
    };
    if leaf(0x8000_0000).eax < *BRAND.end() {
        return None;
    }
    let registers = BRAND.map(leaf).flat_map(|r| [r.eax, r.ebx, r.ecx, r.edx]);
    let bytes: Vec<u8> = registers.flat_map(u32::to_le_bytes).filter(|&byte| byte != 0).collect();
    // Some CPUs pad their names with blanks, even between words.
    let text = String::from_utf8_lossy(&bytes);
    let words: Vec<&str> = text.split_whitespace().collect();
    (!words.is_empty()).then(|| format!("{} (cpuid {:x})", words.join(" "), leaf(1).eax))
}

#[cfg(not(target_arch = "x86_64"))]
fn brand() -> Option<String> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_is_one_line_without_blanks_at_its_ends_and_stays() {
        let name = name();
        assert!(!name.is_empty() && name == name.trim() && name.lines().count() == 1, "{name:?}");
        assert_eq!(name, super::name());
    }
}
