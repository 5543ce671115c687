//! stub
#![allow(missing_docs)]
use crate::board::*;
pub struct Robot { t: u32, back: i32, turn: i32, dir: i16, l: u16, r: u16, il: u8, ir: u8, led: bool, n: u32, dice: u32, vl: i32, vr: i32, pl: i32, pr: i32, }
impl Robot {
    pub fn new(i: Identity) -> Self { Self { t: 0, back: 0, turn: 0, dir: 1, l: 420, r: 420, il: 0, ir: 0, led: false, n: 0, dice: i.dice_seed|1,vl:0,vr:0,pl:0,pr:0 } }
    pub fn tick(&mut self, i: &Inputs) -> Outputs {
        self.t += 1;
        self.dice ^= self.dice << 13; self.dice ^= self.dice >> 17; self.dice ^= self.dice << 5;
        if let Some(e) = i.sonar { let r = e.range_in.unwrap_or(420); match e.side { Side::Left => self.l = r, Side::Right => self.r = r } }
        let b = i.bumper;
        if b.left || b.right || b.center { if self.back <= 0 { self.back = 12; self.turn = 10 + (self.dice % 30) as i32; self.dir = if b.right && !b.left { -1 } else if b.left && !b.right { 1 } else if self.dice & 4 == 0 { 1 } else { -1 }; } }
        let (mut v, mut w) = (12i32, 0i32);
        let (a, d) = (i32::from(self.l), i32::from(self.r));
        if (a - d).abs() * 100 > 15 * (a + d) { w = if d > a { 4 } else { -4 }; if a.min(d) < 40 { w *= 2 } }
        if a < 30 && d < 30 { v = 0; if w == 0 { w = 8 } }
        if self.il > 4 && self.ir > 4 { v = 0; w = 8 * i32::from(self.dir) } else if self.il > 4 { v = 6; w = 6 } else if self.ir > 4 { v = 6; w = -6 }
        if self.back > 0 { self.back -= 1; v = -8; w = 0 } else if self.turn > 0 { self.turn -= 1; v = 0; w = 10 * i32::from(self.dir) }
        // wheels
        let (tl, tr) = (v + w / 2, v - w / 2);
        let ml = i32::from(i.counts_left) * 20 * self.pl.signum(); let mr = i32::from(i.counts_right) * 20 * self.pr.signum();
        self.vl += (tl * 16 - ml) / 16; self.vr += (tr * 16 - mr) / 16;
        self.vl = self.vl.clamp(-120, 120); self.vr = self.vr.clamp(-120, 120);
        self.pl = (tl * 16 + self.vl).clamp(-255, 255); self.pr = (tr * 16 + self.vr).clamp(-255, 255);
        Outputs { pwm_left: self.pl as i16, pwm_right: self.pr as i16, ping: if self.t % 4 == 0 { Some(Side::Left) } else if self.t % 4 == 2 { Some(Side::Right) } else { None }, note_hz: 0 }
    }
    pub fn infrared_look(&mut self, l: bool, r: bool) -> bool { if self.led { self.il = if l { self.il.saturating_add(1).min(10) } else { 0 }; self.ir = if r { self.ir.saturating_add(1).min(10) } else { 0 }; } self.led = !self.led; self.led }
    pub fn handle_uplink(&mut self, _b: u8) {}
    pub fn poll_downlink(&mut self) -> Option<u8> { self.n += 1; if self.n % 81 == 0 { None } else { Some(b'0' + (self.n % 64) as u8) } }
}
