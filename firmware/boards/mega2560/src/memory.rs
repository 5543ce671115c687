//! Parameters and boot counter in the EEPROM.

use sr04_firmware::memory::{
    BOOTS_BYTES, COPY_BYTES, CopyWriter, boots_copy, newer_boots, newer_copy, read_boots, read_copy,
};
use sr04_firmware::parameters::Parameters;

use crate::registers::{eeprom_is_ready, read_eeprom, write_eeprom};

/// Places of the boot counter's two copies. The first bytes of an EEPROM are those that a dying chip may hit.
const BOOTS: [u16; 2] = [16, 32];

/// Places of the parameters' two copies.
const COPIES: [u16; 2] = [64, 64 + COPY_BYTES];

/// The EEPROM.
pub struct Memory {
    /// Number of the newest copy of the parameters, and whether it is the second one.
    number: u8,
    is_second: bool,
    /// Parameters that are being written.
    keeping: Parameters,
    writing: Option<Writing>,
}

struct Writing {
    copy: CopyWriter,
    address: u16,
}

impl Memory {
    /// Reads the EEPROM; returns the parameters too.
    #[inline(never)]
    pub fn open() -> (Self, Parameters) {
        let copy = |place: u16| read_copy((place..place + COPY_BYTES).map(read_eeprom));
        let (number, parameters, is_second) = newer_copy(copy(COPIES[0]), copy(COPIES[1]));
        let memory = Self {
            number,
            is_second,
            keeping: Parameters::DEFAULT,
            writing: None,
        };
        (memory, parameters)
    }

    /// Keeps these parameters, a byte at a time.
    pub fn keep(&mut self, parameters: &Parameters) {
        self.keeping.clone_from(parameters);
        self.writing = Some(Writing {
            copy: CopyWriter::after(self.number),
            address: COPIES[usize::from(!self.is_second)],
        });
    }

    /// Writes the next byte if the EEPROM is ready. Bytes that are there already are not written again.
    pub fn step(&mut self) {
        let Some(writing) = &mut self.writing else {
            return;
        };
        while eeprom_is_ready() {
            let Some(byte) = writing.copy.next_byte(&self.keeping) else {
                self.number = writing.copy.number();
                self.is_second = !self.is_second;
                self.writing = None;
                return;
            };
            let address = writing.address;
            writing.address += 1;
            if read_eeprom(address) != byte {
                write_eeprom(address, byte);
                return;
            }
        }
    }
}

/// Counts this boot: at most 17 ms.
#[inline(never)]
pub fn count_boot() -> u16 {
    // A write that a watchdog's reset or a brown-out met goes on.
    while !eeprom_is_ready() {}
    let copy = |place: u16| {
        let mut bytes = [0; BOOTS_BYTES];
        for (byte, address) in bytes.iter_mut().zip(place..) {
            *byte = read_eeprom(address);
        }
        read_boots(bytes)
    };
    let (boots, is_second) = newer_boots(copy(BOOTS[0]), copy(BOOTS[1]));
    let boots = boots.wrapping_add(1);
    let place = BOOTS[usize::from(!is_second)];
    for (byte, address) in boots_copy(boots).into_iter().zip(place..) {
        while !eeprom_is_ready() {}
        write_eeprom(address, byte);
    }
    while !eeprom_is_ready() {}
    boots
}
