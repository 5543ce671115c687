//! Parameters and boot counter in the last 16 KB of the flash. A sector is erased as a whole, so copies are written one
//! after the other into pages of two sectors, and a sector is erased only when the newest copy is in the other one.

use rp2040_flash::flash::{flash_range_erase, flash_range_program};
use sr04_firmware::memory::{BOOTS_BYTES, CopyWriter, boots_copy, read_boots, read_copy};
use sr04_firmware::parameters::Parameters;

/// Where the processor sees the flash.
const FLASH: u32 = 0x1000_0000;

const SECTOR_BYTES: u32 = 4096;
const PAGE_BYTES: u32 = 256;
const SECTOR_PAGES: u32 = SECTOR_BYTES / PAGE_BYTES;

/// Offsets of the two sectors of each record.
const BOOTS: u32 = (2048 << 10) - 4 * SECTOR_BYTES;
const COPIES: u32 = BOOTS + 2 * SECTOR_BYTES;

type Page = [u8; PAGE_BYTES as usize];

fn read_page(offset: u32) -> Page {
    let address = (FLASH + offset) as *const Page;
    // SAFETY: the offsets are those of pages within the flash, which is always readable; another value may be there each
    // time.
    unsafe { address.read_volatile() }
}

fn is_blank(page: &Page) -> bool {
    page.iter().all(|&byte| byte == u8::MAX)
}

/// Two sectors with copies of a record.
struct Journal {
    begin: u32,
    /// Page of the newest copy; `None` without one.
    newest: Option<u32>,
}

impl Journal {
    /// Finds the newest copy: `is_after` compares two of them.
    fn open<T: Clone>(
        begin: u32,
        read: impl Fn(&Page) -> Option<T>,
        is_after: impl Fn(&T, &T) -> bool,
    ) -> (Self, Option<T>) {
        let mut found: Option<(u32, T)> = None;
        for page in 0..2 * SECTOR_PAGES {
            if let Some(copy) = read(&read_page(begin + page * PAGE_BYTES))
                && found
                    .as_ref()
                    .is_none_or(|(_, other)| is_after(&copy, other))
            {
                found = Some((page, copy));
            }
        }
        let journal = Self {
            begin,
            newest: found.as_ref().map(|&(page, _)| page),
        };
        (journal, found.map(|(_, copy)| copy))
    }

    /// Writes a copy into the next page. That takes 3 ms, or up to 400 ms if its sector must be erased.
    fn append(&mut self, page: &Page) {
        let next = self
            .newest
            .map_or(0, |newest| (newest + 1) % (2 * SECTOR_PAGES));
        let mut offset = self.begin + next * PAGE_BYTES;
        let mut place = next;
        if !is_blank(&read_page(offset)) {
            // The begin of a sector, or a page that power loss has spoilt.
            place = (next.div_ceil(SECTOR_PAGES) * SECTOR_PAGES) % (2 * SECTOR_PAGES);
            offset = self.begin + place * PAGE_BYTES;
            critical_section::with(|_| {
                // SAFETY: interrupts are off, the second core does not run, the sector is inside the flash and holds no
                // code.
                unsafe { flash_range_erase(offset, SECTOR_BYTES, true) };
            });
        }
        critical_section::with(|_| {
            // SAFETY: as above; the page is blank.
            unsafe { flash_range_program(offset, page, true) };
        });
        self.newest = Some(place);
    }
}

/// Counts this boot.
pub fn count_boot() -> u16 {
    let read = |page: &Page| {
        let copy: [u8; BOOTS_BYTES] = core::array::from_fn(|place| page[place]);
        read_boots(copy)
    };
    let is_after = |boots: &u16, other: &u16| boots.wrapping_sub(*other) as i16 > 0;
    let (mut journal, newest) = Journal::open(BOOTS, read, is_after);
    let boots = newest.unwrap_or_default().wrapping_add(1);
    let mut page = [u8::MAX; PAGE_BYTES as usize];
    page[..BOOTS_BYTES].copy_from_slice(&boots_copy(boots));
    journal.append(&page);
    boots
}

/// The parameters.
pub struct Memory {
    journal: Journal,
    number: u8,
}

impl Memory {
    /// Reads the flash; returns the parameters too.
    pub fn open() -> (Self, Parameters) {
        let read = |page: &Page| read_copy(page.iter().copied());
        let is_after = |copy: &(u8, Parameters), other: &(u8, Parameters)| {
            copy.0.wrapping_sub(other.0) as i8 > 0
        };
        let (journal, newest) = Journal::open(COPIES, read, is_after);
        let (number, parameters) = newest.unwrap_or((0, Parameters::DEFAULT));
        (Self { journal, number }, parameters)
    }

    /// Keeps these parameters.
    pub fn keep(&mut self, parameters: &Parameters) {
        let mut copy = CopyWriter::after(self.number);
        let mut page = [u8::MAX; PAGE_BYTES as usize];
        for place in &mut page {
            let Some(byte) = copy.next_byte(parameters) else {
                break;
            };
            *place = byte;
        }
        self.number = copy.number();
        self.journal.append(&page);
    }
}
