//! The head of an object file: is it a shared library, and for which machine?

use crate::error::Refusal;

/// As many bytes as are looked at.
pub(crate) const HEAD: usize = 20;

/// The kind "shared object" of an ELF file, and what another kind is called here.
const SHARED: u16 = 3;
const UNLINKED: &str = "no shared library";

/// Architectures by name, with their numbers in ELF and Mach-O headers.
const MACHINES: [(&str, u16, u32); 4] = [
    ("x86_64", 62, 0x0100_0007),
    ("aarch64", 183, 0x0100_000c),
    ("riscv64", 243, 0),
    ("powerpc64", 21, 0x0100_0012),
];

/// Checks the first bytes of a file.
pub(crate) fn check(head: &[u8]) -> Result<(), Refusal> {
    let host = (format_of_host(), std::env::consts::ARCH);
    let shown = |format: &str, machine: &str| format!("{format} {machine}");
    match read(head) {
        None => Err(Refusal::NotALibrary {
            first: head.iter().take(8).copied().collect(),
        }),
        Some((format, machine)) if (format, machine.as_str()) == host => Ok(()),
        Some((_, machine)) if machine == UNLINKED => Err(Refusal::NotShared),
        Some((format, machine)) => Err(Refusal::Machine {
            found: shown(format, &machine),
            host: shown(host.0, host.1),
        }),
    }
}

fn format_of_host() -> &'static str {
    if cfg!(target_vendor = "apple") {
        "Mach-O"
    } else if cfg!(windows) {
        "PE"
    } else {
        "ELF"
    }
}

/// Format and machine of a shared library.
fn read(head: &[u8]) -> Option<(&'static str, String)> {
    let u16_at = |at: usize| Some(u16::from_le_bytes([*head.get(at)?, *head.get(at + 1)?]));
    if head.starts_with(b"\x7fELF") {
        // A 64-bit little-endian file, of the kind "shared object".
        if (head.get(4)?, head.get(5)?) != (&2, &1) {
            return Some(("ELF", "32-bit or big-endian".to_owned()));
        }
        if u16_at(16)? != SHARED {
            return Some(("ELF", UNLINKED.to_owned()));
        }
        let number = u16_at(18)?;
        let known = MACHINES.iter().find(|machine| machine.1 == number);
        let machine = known.map_or_else(|| format!("machine {number}"), |m| m.0.to_owned());
        return Some(("ELF", machine));
    }
    if head.starts_with(&[0xcf, 0xfa, 0xed, 0xfe]) {
        let number = u32::from_le_bytes(head.get(4..8)?.try_into().ok()?);
        let known = MACHINES.iter().find(|machine| machine.2 == number);
        let machine = known.map_or_else(|| format!("machine {number:#x}"), |m| m.0.to_owned());
        return Some(("Mach-O", machine));
    }
    head.starts_with(b"MZ")
        .then(|| ("PE", "of Windows".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elf(class: u8, kind: u8, machine: u8) -> Vec<u8> {
        let mut head = b"\x7fELF".to_vec();
        head.extend([class, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, kind, 0, machine, 0]);
        head
    }

    #[test]
    fn a_library_of_another_machine_is_told_from_one_of_this() {
        let read = |head: &[u8]| read(head).map(|(format, machine)| format!("{format} {machine}"));
        assert_eq!(read(&elf(2, 3, 62)).as_deref(), Some("ELF x86_64"));
        assert_eq!(read(&elf(2, 3, 183)).as_deref(), Some("ELF aarch64"));
        assert_eq!(read(&elf(2, 3, 8)).as_deref(), Some("ELF machine 8"));
        let mac = [0xcf, 0xfa, 0xed, 0xfe, 0x0c, 0, 0, 1];
        assert_eq!(read(&mac).as_deref(), Some("Mach-O aarch64"));
        assert_eq!(read(b"MZ\x90\x00").as_deref(), Some("PE of Windows"));
        assert!(matches!(check(&elf(1, 3, 3)), Err(Refusal::Machine { .. })));
        // A program, and what the compiler makes before it is linked.
        for other in [elf(2, 2, 62), elf(2, 1, 62)] {
            assert_eq!(check(&other), Err(Refusal::NotShared));
        }
    }

    #[test]
    fn what_is_no_library_shows_its_first_bytes() {
        for (head, first) in [(&b""[..], &b""[..]), (b"hello, library", b"hello, l")] {
            let expected = Refusal::NotALibrary {
                first: first.to_vec(),
            };
            assert_eq!(check(head), Err(expected));
        }
    }
}
