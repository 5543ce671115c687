//! Line C: who the robot is and what it has counted.
//!
//! ```text
//! 1-3  5-6 8-13   15-17 19-23 25-42              44-46 48-50 52-54 56-59 70-74 75-78
//! C53  07  000412 004   01.00 `````3`````V*4``,0 133   002   000   0012  !5:HS ^*"+
//! seq  id  uptime boots vers. ticks won          heard bad   late  bumps ack   CRC
//! ```
//!
//! Ticks won: two 6-bit characters for each of [`HOLDERS`] holders.

use super::FieldError;
use super::columns::{Columns, Fields, bad};

/// Whoever can hold the motors: layers 0 to 7, then prowl.
pub const HOLDERS: usize = 9;

/// Line C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountersLine {
    /// 1 to 99.
    pub robot_id: u8,
    /// Seconds since boot by the robot's clock, modulo 1,000,000.
    pub uptime_s: u32,
    /// Boot counter, modulo 1000.
    pub boots: u16,
    /// Firmware version.
    pub version: FirmwareVersion,
    /// Ticks won by layers 0 to 7 and by prowl since boot, modulo 4096.
    pub ticks_won: [u16; HOLDERS],
    /// Intact uplink frames since boot, modulo 1000.
    pub frames_heard: u16,
    /// Uplink frames rejected since boot, modulo 1000.
    pub frames_rejected: u16,
    /// Ticks that began late since boot, modulo 1000.
    pub ticks_late: u16,
    /// Bumper contacts since boot, modulo 10,000.
    pub bumps: u16,
}

/// Two numbers of two digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FirmwareVersion {
    /// Changes when the robot behaves differently to the operator.
    pub major: u8,
    /// Everything else.
    pub minor: u8,
}

impl CountersLine {
    pub(super) fn write(&self, columns: &mut Columns) {
        columns.digits(5, 2, u32::from(self.robot_id.max(1)));
        columns.digits(8, 6, self.uptime_s % 1_000_000);
        columns.digits(15, 3, u32::from(self.boots % 1000));
        columns.digits(19, 2, u32::from(self.version.major));
        columns.letter(21, b'.');
        columns.digits(22, 2, u32::from(self.version.minor));
        for (i, &ticks) in self.ticks_won.iter().enumerate() {
            columns.sixbit(25 + 2 * i, 2, u32::from(ticks % 4096));
        }
        columns.digits(44, 3, u32::from(self.frames_heard % 1000));
        columns.digits(48, 3, u32::from(self.frames_rejected % 1000));
        columns.digits(52, 3, u32::from(self.ticks_late % 1000));
        columns.digits(56, 4, u32::from(self.bumps % 10_000));
    }

    pub(super) fn read(c: &Fields) -> Result<Self, FieldError> {
        c.spaces(&[
            4, 7, 14, 18, 24, 43, 47, 51, 55, 60, 61, 62, 63, 64, 65, 66, 67, 68, 69,
        ])?;
        let robot_id = c.number::<2>(5)? as u8;
        if robot_id == 0 {
            return Err(bad(5));
        }
        let (major, minor) = c.pair::<2, 2>(19, b'.')?;
        let mut ticks_won = [0; HOLDERS];
        for (i, ticks) in ticks_won.iter_mut().enumerate() {
            *ticks = c.sixbit_number::<2>(25 + 2 * i)? as u16;
        }
        Ok(Self {
            robot_id,
            uptime_s: c.number::<6>(8)?,
            boots: c.number::<3>(15)? as u16,
            version: FirmwareVersion {
                major: major as u8,
                minor: minor as u8,
            },
            ticks_won,
            frames_heard: c.number::<3>(44)? as u16,
            frames_rejected: c.number::<3>(48)? as u16,
            ticks_late: c.number::<3>(52)? as u16,
            bumps: c.number::<4>(56)? as u16,
        })
    }
}
