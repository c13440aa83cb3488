//! Emulates AMX on machines without it, for tests: the CPU traps on the unknown instructions, and a
//! handler of SIGILL decodes and performs them (Intel SDM volume 2, chapters on AMX).

use std::cell::RefCell;
use std::sync::OnceLock;

use libc::{c_int, c_void, siginfo_t, ucontext_t};

use super::super::amx::Amx;

/// The tiles of a thread, and whether they are configured.
struct Tiles {
    data: [[u8; 1024]; 8],
    configured: bool,
}

thread_local! {
    static TILES: RefCell<Tiles> =
        const { RefCell::new(Tiles { data: [[0; 1024]; 8], configured: false }) };
}

/// Returns the AMX kernel, after installing the handler for this process; fails without
/// AVX-512 VNNI, which the kernel needs too, and on a CPU with AMX.
pub(super) fn amx() -> Result<&'static Amx, &'static str> {
    static AMX: OnceLock<Result<Amx, &'static str>> = OnceLock::new();
    let install = || {
        let kernel = Amx::emulated()?;
        // SAFETY: the action is fully initialized, and the handler has the three arguments that
        // SA_SIGINFO promises. It runs on the stack of the thread that trapped, below the red zone,
        // and the system restores the registers of that thread.
        unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            action.sa_sigaction = handler as *const () as usize;
            action.sa_flags = libc::SA_SIGINFO;
            assert_eq!(libc::sigaction(libc::SIGILL, &action, std::ptr::null_mut()), 0);
        }
        Ok(kernel)
    };
    AMX.get_or_init(install).as_ref().map_err(|why| *why)
}

extern "C" fn handler(_signal: c_int, _info: *mut siginfo_t, context: *mut c_void) {
    // SAFETY: the system passes the registers of the interrupted thread, which nobody else uses
    // until the handler returns.
    let registers = unsafe { &mut (*context.cast::<ucontext_t>()).uc_mcontext.gregs };
    let at = registers[libc::REG_RIP as usize] as *const u8;
    // SAFETY: the longest encoding is ten bytes, and more code follows these instructions.
    let code = unsafe { std::slice::from_raw_parts(at, 10) };
    match perform(code, registers) {
        Some(length) => registers[libc::REG_RIP as usize] += length,
        None => {
            eprintln!("emulator: unknown instruction {code:02x?}");
            std::process::abort();
        }
    }
}

/// Performs one instruction and returns its length in bytes; `None` if it is not one that the
/// kernel uses.
fn perform(code: &[u8], registers: &[i64]) -> Option<i64> {
    // The three-byte VEX prefix of the map 0F38, W0, 128 bits.
    let [0xc4, extensions, fields, opcode, modrm, rest @ ..] = code else { return None };
    if extensions & 0x1f != 2 || fields & 0x84 != 0 {
        return None;
    }
    let prefix = fields & 3;
    let (mode, reg, rm) = (modrm >> 6, usize::from(modrm >> 3 & 7), modrm & 7);
    TILES.with_borrow_mut(|tiles| match (opcode, prefix, mode) {
        (0x49, 0, 3) => {
            // tilerelease
            *tiles = Tiles { data: [[0; 1024]; 8], configured: false };
            Some(5)
        }
        (0x49, 0, _) => {
            let (address, length) = address(*extensions, mode, rm, rest, registers)?;
            // SAFETY: the operand of ldtilecfg is 64 bytes.
            let config = unsafe { std::slice::from_raw_parts(address.0 as *const u8, 64) };
            // Only the configuration of the kernel is emulated.
            let row_bytes = config[16..32].chunks(2).all(|c| c == [64, 0]);
            tiles.configured = config[0] == 1 && row_bytes && config[48..56] == [16; 8];
            tiles.configured.then_some(length)
        }
        (0x49, 3, 3) if tiles.configured => {
            // tilezero
            tiles.data[reg] = [0; 1024];
            Some(5)
        }
        // tileloaddt1, tilestored, tileloadd
        (0x4b, 1..=3, _) if tiles.configured => {
            let ((base, stride), length) = address(*extensions, mode, rm, rest, registers)?;
            for (i, row) in tiles.data[reg].chunks_mut(64).enumerate() {
                let memory = (base + stride * i as i64) as *mut u8;
                // SAFETY: loads read, and tilestored writes, 64 bytes there.
                unsafe {
                    if prefix != 2 {
                        memory.copy_to(row.as_mut_ptr(), 64);
                    } else {
                        memory.copy_from(row.as_ptr(), 64);
                    }
                }
            }
            Some(length)
        }
        (0x5e, 3, 3) if tiles.configured => {
            // tdpbssd: the second factor is in VEX.vvvv.
            let right = usize::from(!fields >> 3 & 7);
            let (left, right) = (tiles.data[usize::from(rm)], tiles.data[right]);
            for i in 0..16 {
                for j in 0..16 {
                    let product = |k: usize| {
                        let (l, r) = (left[64 * i + k], right[64 * (k / 4) + 4 * j + k % 4]);
                        i32::from(l as i8) * i32::from(r as i8)
                    };
                    let sum = &mut tiles.data[reg][64 * i + 4 * j..][..4];
                    let old = i32::from_le_bytes(sum.try_into().expect("four bytes"));
                    let new = (0..64).map(product).fold(old, i32::wrapping_add);
                    sum.copy_from_slice(&new.to_le_bytes());
                }
            }
            Some(5)
        }
        _ => None,
    })
}

/// Returns the base and the stride of a memory operand and the length of the instruction, in bytes;
/// `None` for an encoding that is not emulated.
fn address(
    extensions: u8,
    mode: u8,
    rm: u8,
    rest: &[u8],
    registers: &[i64],
) -> Option<((i64, i64), i64)> {
    const ORDER: [c_int; 16] = [
        libc::REG_RAX,
        libc::REG_RCX,
        libc::REG_RDX,
        libc::REG_RBX,
        libc::REG_RSP,
        libc::REG_RBP,
        libc::REG_RSI,
        libc::REG_RDI,
        libc::REG_R8,
        libc::REG_R9,
        libc::REG_R10,
        libc::REG_R11,
        libc::REG_R12,
        libc::REG_R13,
        libc::REG_R14,
        libc::REG_R15,
    ];
    let value = |number: u8| registers[ORDER[usize::from(number)] as usize];
    // B and X are stored inverted.
    let (b, x) = ((!extensions >> 5 & 1) << 3, (!extensions >> 6 & 1) << 3);
    let (base, stride, rest, mut length) = if rm == 4 {
        let (&sib, rest) = rest.split_first()?;
        let index = sib >> 3 & 7 | x;
        let stride = if index == 4 { 0 } else { value(index) << (sib >> 6) };
        (sib & 7, stride, rest, 6)
    } else {
        (rm, 0, rest, 5)
    };
    // rbp and r13 without a displacement mean something else, which is not emulated.
    if mode == 0 && base == 5 {
        return None;
    }
    let displacement = match mode {
        0 => 0,
        1 => i64::from(*rest.first()? as i8),
        _ => i32::from_le_bytes(rest.get(..4)?.try_into().ok()?).into(),
    };
    length += [0, 1, 4][usize::from(mode)];
    Some(((value(base | b) + displacement, stride), length))
}
