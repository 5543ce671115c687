//! `groundwave check --send`: a correct robot keeps every rule, and each planted fault is reported. Runs in virtual time.

use std::collections::VecDeque;
use std::time::Duration;

use groundwave::conformance::{Trials, Verdict};
use sr04_firmware::board::Duplex;
use sr04_sim::{Simulation, SimulationConfig, World};

#[cfg(unix)]
use crate::common::c_robot::{BOOTS, CRobot};
use crate::common::{Patch, on_all_cores, seeds};

const BAUD: u32 = 2400;
const OWNER: u16 = 0x2A4;

/// Maximum duration of the trials.
const LIMIT: Duration = Duration::from_mins(20);

/// A robot under trial.
trait Robot {
    fn now(&self) -> Duration;
    /// Advances by a time step; takes bytes of the uplink and returns those of the robot.
    fn step(&mut self, uplink: &mut VecDeque<u8>) -> Vec<u8>;
    fn reset(&mut self);
}

impl Robot for Simulation {
    fn now(&self) -> Duration {
        Duration::from_millis(self.now_ms())
    }

    fn step(&mut self, uplink: &mut VecDeque<u8>) -> Vec<u8> {
        self.handle_uplink(&uplink.drain(..).collect::<Vec<_>>());
        Self::step(self);
        std::iter::from_fn(|| self.poll_downlink()).collect()
    }

    fn reset(&mut self) {
        self.reboot();
    }
}

/// Runs the trials to their end.
fn tried(robot: &mut impl Robot) -> Trials {
    tried_until(robot, Trials::is_over)
}

/// Runs the trials until a condition holds; resets the robot when they request a reset.
fn tried_until(robot: &mut impl Robot, is_enough: impl Fn(&Trials) -> bool) -> Trials {
    let mut trials = Trials::new(OWNER, BAUD);
    let mut uplink = VecDeque::new();
    while !is_enough(&trials) {
        let bytes = robot.step(&mut uplink);
        let now = robot.now();
        assert!(now < LIMIT, "the trials do not end: {trials:?}");
        if !bytes.is_empty() {
            trials.handle_bytes(now, &bytes);
        }
        if trials.poll_timeout().is_some_and(|at| at <= now) {
            trials.handle_timeout(now);
        }
        while let Some(bytes) = trials.poll_transmit() {
            uplink.extend(bytes);
        }
        while trials.poll_verdict().is_some() {}
        if trials.poll_prompt().is_some() {
            robot.reset();
        }
    }
    trials
}

/// Codes of the rules that the robot breaks.
fn broken(trials: &Trials) -> Vec<&'static str> {
    let broken = trials
        .verdicts()
        .iter()
        .filter_map(|verdict| match verdict {
            Verdict::Broken(rule, _) => Some(rule.code),
            _ => None,
        });
    broken.collect()
}

fn kept(trials: &Trials) -> usize {
    let kept = trials.verdicts().iter();
    kept.filter(|verdict| matches!(verdict, Verdict::Kept(_)))
        .count()
}

fn simulated(channel: &str, duplex: Duplex, seed: u64) -> Simulation {
    let world = World::built_in("open-room").unwrap();
    let mut config = SimulationConfig::new(world, seed);
    config.channel = channel.parse().unwrap();
    config.duplex = duplex;
    Simulation::new(&config)
}

#[test]
fn the_simulated_robot_keeps_every_rule_over_any_radio() {
    let half = Duplex::Half { patience_bytes: 16 };
    let radios = [
        ("", Duplex::Full),
        ("ber=1e-3", Duplex::Full),
        ("half-duplex", half),
        ("half-duplex,ber=3e-4", half),
    ];
    on_all_cores(seeds(radios.len() as u64), |seed| {
        let (channel, duplex) = radios[seed as usize % radios.len()];
        let trials = tried(&mut simulated(channel, duplex, seed));
        let context = format!("channel `{channel}`, seed {seed}: {trials:?}");
        assert_eq!(broken(&trials), [""; 0], "{context}");
        assert!(kept(&trials) >= 43, "{} kept; {context}", kept(&trials));
        assert_eq!(trials.level(), Some(5), "{context}");
    });
}

/// A robot in C, with or without a working boot counter.
#[cfg(unix)]
struct InC {
    robot: CRobot,
    patience_bytes: u8,
    boots: u8,
    counts_boots: bool,
}

#[cfg(unix)]
impl InC {
    fn start(level: u8, patience_bytes: u8, patches: &[Patch]) -> Self {
        Self {
            robot: CRobot::start(level, patience_bytes, 40, patches),
            patience_bytes,
            boots: BOOTS,
            counts_boots: true,
        }
    }
}

#[cfg(unix)]
impl Robot for InC {
    fn now(&self) -> Duration {
        self.robot.now()
    }

    fn step(&mut self, uplink: &mut VecDeque<u8>) -> Vec<u8> {
        self.robot
            .exchange(uplink.pop_front())
            .into_iter()
            .collect()
    }

    fn reset(&mut self) {
        self.boots += u8::from(self.counts_boots);
        self.robot.boot(self.boots, self.patience_bytes);
    }
}

#[cfg(unix)]
#[test]
fn a_correct_c_robot_keeps_every_rule_at_every_level_and_duplex() {
    for (level, patience_bytes, least) in
        [(2, 0, 22), (3, 0, 30), (4, 0, 45), (5, 0, 50), (5, 16, 47)]
    {
        let trials = tried(&mut InC::start(level, patience_bytes, &[]));
        let context = format!(
            "level {level}, patience {patience_bytes}: {:?}",
            trials.verdicts()
        );
        assert_eq!(broken(&trials), [""; 0], "{context}");
        assert!(kept(&trials) >= least, "{} kept; {context}", kept(&trials));
        assert_eq!(trials.level(), Some(level), "{context}");
    }
}

/// A fault, as a change of the C library, and the rule that must be reported as broken.
#[rustfmt::skip]
pub const FAULTS: &[(&str, u8, Patch, &str)] = &[
    ("STOP without effect", 2, ("case 'X':\n        if (gw->owner != 0) {", "case 'X':\n        break;\n        if (gw->owner != 0) {"), "stop"),
    ("STOP under key 0 alone", 2, ("holds(frame, count, robot_key(gw)) || holds(frame, count, 0)", "holds(frame, count, 0)"), "stop"),
    ("STOP without a receipt", 2, ("gw->receipt = message->receipt;", ""), "stop-receipt"),
    ("STOP that leaves the mode", 2, ("enter_mode(gw, 'X');\n        gw_stop();", "gw_stop();"), "stop-mode"),
    ("STOPs that are not counted", 2, ("gw->sequence = (gw->sequence + 1) & 63;", ""), "stop-again"),
    ("STOP for every robot ignored", 2, ("holds(frame, count, robot_key(gw)) || holds(frame, count, 0)", "holds(frame, count, robot_key(gw))"), "stop-any"),
    ("STOP that leaves the session open", 2, ("if (gw->owner != 0) {\n            begin_session(gw, 0);\n        } else {", "{"), "stop-session"),
    ("an open of another boot", 2, ("message->boot == (gw->boots & 7) && ", ""), "open-stale"),
    ("an open of another session", 2, (" && message->replaces == gw->session", ""), "open-stale"),
    ("an open of another era", 2, ("message->era == GW_NONE || message->era == (int16_t)gw->era", "1"), "open-stale"),
    ("an open that keeps the session's number", 2, ("begin_session(gw, message->owner);", "gw->owner = message->owner;"), "open"),
    ("an open without the long form", 2, ("(count != 3 && count != 6)", "count != 3"), "open-era"),
    ("the era left out of the key", 2, ("gw->is_numbered = message->era != GW_NONE;", ""), "session-key"),
    ("the boot left out of the key", 2, ("(gw->boots & 7) << 13 | gw->session << 10 | gw->owner", "gw->session << 10 | gw->owner"), "session-key"),
    ("the session left out of the key", 2, (" << 13 | gw->session << 10 | gw->owner", " << 13 | gw->owner"), "session-key"),
    ("the owner left out of the key", 2, ("gw->session << 10 | gw->owner", "gw->session << 10"), "session-key"),
    ("commands without effect", 2, ("case 'C':\n        if (message->sequence", "case 'C':\n        break;\n        if (message->sequence"), "command"),
    ("a mode that is not entered", 2, ("enter_mode(gw, message->mode);", ""), "mode"),
    ("every command executed", 2, ("message->sequence == ((gw->sequence + 1) & 63)", "1"), "repeated-command"),
    ("every command but the latest executed", 2, ("message->sequence == ((gw->sequence + 1) & 63)", "message->sequence != gw->sequence"), "repeated-command"),
    ("every later command executed", 2, ("message->sequence == ((gw->sequence + 1) & 63)", "((message->sequence - gw->sequence - 1) & 63) < 32"), "command-gap"),
    ("the key of any session", 2, ("is_intact = gw->owner != 0 && holds(frame, count, session_key(gw));", "is_intact = 0;\n        for (uint32_t n = 0; n < 8; n++) { is_intact |= holds(frame, count, session_key(gw) ^ n << 10); }"), "wrong-session"),
    ("the key of any owner", 2, ("is_intact = gw->owner != 0 && holds(frame, count, session_key(gw));", "is_intact = 0;\n        for (uint32_t n = 0; n < 1024; n++) { is_intact |= holds(frame, count, session_key(gw) ^ n); }"), "wrong-owner"),
    ("the key of any boot", 2, ("is_intact = gw->owner != 0 && holds(frame, count, session_key(gw));", "is_intact = 0;\n        for (uint32_t n = 0; n < 8; n++) { is_intact |= holds(frame, count, session_key(gw) ^ n << 13); }"), "wrong-boot"),
    ("the key of any robot", 2, ("is_intact = gw->owner != 0 && holds(frame, count, session_key(gw));", "is_intact = 0;\n        for (uint32_t n = 0; n < 128; n++) { is_intact |= holds(frame, count, session_key(gw) ^ n << 16); }"), "wrong-robot"),
    ("three of four characters of the checksum compared", 2, ("memcmp(checksum, bytes + count, CRC_BYTES) == 0", "memcmp(checksum, bytes + count, 3) == 0"), "damaged-frame"),
    ("a session that ends unknown orders as done", 2, ("default:\n        return GW_UNKNOWN;\n    }\n}\n\n#if GW_LEVEL >= 3\nstatic void stage", "default:\n        return GW_DONE;\n    }\n}\n\n#if GW_LEVEL >= 3\nstatic void stage"), "unknown-order"),
    ("a command with an unreadable order dropped", 2, ("message->order = '?';\n        }\n        return 1;", "return 0;\n        }\n        return 1;"), "unknown-order"),
    ("a mode's letter that is not checked", 2, ("return count == 1 && is_mode(message->mode);", "return 1;"), "unreadable-order"),
    ("an order beyond the level taken for another one", 2, ("message->order = '?';\n        }\n        return 1;", "message->mode = 'X';\n            message->order = message->order == 'A' ? 'M' : '?';\n        }\n        return 1;"), "beyond-level"),
    ("a mode that is not fitted entered", 2, ("case 'M':\n        if (strchr(gw->modes, message->mode) == NULL) {", "case 'M':\n        if (0) {"), "not-fitted"),
    ("X and Y swapped in waypoints", 3, ("get_waypoint(gw->frame + 3 + 5 * n, &waypoint->x_in, &waypoint->y_in);", "get_waypoint(gw->frame + 3 + 5 * n, &waypoint->y_in, &waypoint->x_in);"), "list"),
    ("a digest without the count", 3, ("crc32_pair(0xFFFFFFFF, count)", "0xFFFFFFFF"), "list"),
    ("a list with waypoints missing", 3, (" && first_missing(gw) >= (count + BLOCK - 1) / BLOCK", ""), "list-missing"),
    ("a digest that is not compared", 3, ("if (list_digest(gw->banks[bank], count) != digest) {", "if (0) {"), "list-digest"),
    ("a digest compared in 16 bits", 3, ("list_digest(gw->banks[bank], count) != digest", "(list_digest(gw->banks[bank], count) ^ digest) >> 16 != 0"), "list-digest"),
    ("line B with the digest before", 3, ("gw->active_digest = digest;\n    gw->reached", "gw->reached"), "list-status"),
    ("a list beyond the capacity", 3, ("if (count > GW_WAYPOINTS) {\n        return GW_BAD_VALUE;", "if (count > GW_WAYPOINTS) {\n        return GW_LIST_INCOMPLETE;"), "list-capacity"),
    ("a staged list that changes the active one", 3, ("&gw->banks[1 - gw->active_bank][first + n];", "&gw->banks[1 - gw->active_bank][first + n];\n        gw->active_digest ^= 1;"), "list-kept"),
    ("waypoints written into the active bank", 3, ("&gw->banks[1 - gw->active_bank][first + n];", "&gw->banks[gw->active_bank][first + n];"), "list"),
    ("a tag used again", 3, ("if (ahead == 0 ? !gw->staged_is_open : ahead > 15) {\n        return;\n    }\n    if (ahead > 0) {", "if (!gw->staged_is_open || ahead > 0) {"), "list-tag"),
    ("an empty list that is refused", 3, ("if (count > 0 && !(gw->staged_is_open", "if (!(gw->staged_is_open"), "list-clear"),
    ("no lines K", 4, ("gw->echoes_due = 4;", "gw->echoes_due = 0;"), "knock"),
    ("frames that are not counted", 4, ("gw->frames_heard++;", ""), "heard"),
    ("a pose that is set twice", 4, ("message->sequence == ((gw->sequence + 1) & 63)", "((gw->sequence + 1 - message->sequence) & 63) < 2"), "repeated-pose"),
    ("drive frames without effect", 4, ("case 'D':\n        drive(gw, message, now_ms);", "case 'D':"), "drive"),
    ("hand drive without an end", 4, ("if (gw->is_driven && now_ms - gw->drive_ms >= 1000) {", "if (0) {"), "drive-end"),
    ("hand drive that ends after 3 s", 4, ("gw->is_driven && now_ms - gw->drive_ms >= 1000", "gw->is_driven && now_ms - gw->drive_ms >= 3000"), "drive-end"),
    ("stale drive frames obeyed", 4, ("!gw->is_live\n        || !is_recent(gw, message->heard, now_ms)", "!gw->is_live"), "drive-stale"),
    ("drive frames obeyed twice", 4, ("ahead < 1 || ahead > 7 || ", ""), "drive-repeated"),
    ("drive frames obeyed whether the ground is live or not", 4, (" || !gw->is_live\n", "\n"), "drive-live"),
    ("a drive frame that leaves mode stop", 4, ("gw->mode == 'X' || gw->failsafe_acts", "(gw->mode == 'X' && (gw->mode = 'U', 0)) || gw->failsafe_acts"), "drive-stopped"),
    ("a failsafe of 5 s", 4, ("message->silence_s < 10 || message->mode == 'U'", "message->mode == 'U'"), "failsafe-range"),
    ("a failsafe that is not shown", 4, ("gw->owner != 0 && gw->failsafe_silence_s > 0 ? 'f' : '.'", "'.'"), "failsafe-armed"),
    ("a failsafe that never acts", 4, ("now_ms - gw->frame_ms >= gw->failsafe_silence_s * (uint32_t)1000", "0"), "failsafe"),
    ("a failsafe that acts too early", 4, ("gw->failsafe_silence_s * (uint32_t)1000", "gw->failsafe_silence_s * (uint32_t)500"), "failsafe"),
    ("a failsafe without an end", 4, ("gw->failsafe_acts = 0;", ""), "failsafe-end"),
    ("lines P of one parameter only", 5, ("for (uint8_t index = 0; index < gw->parameter_count; index++) {\n        queue_parameter(gw, index);", "for (uint8_t index = 0; index < 1; index++) {\n        queue_parameter(gw, index);"), "parameters"),
    ("keys of parameters from 0", 5, ("crc24(0xFFFFFF, parameter->name", "crc24(0, parameter->name"), "parameter-set"),
    ("an acknowledgement taken when the line begins", 4, ("if (gw->position == gw->head) {", "if (gw->position == 0) {"), "ack-fresh"),
    ("an order K without effect", 5, ("return keep_parameters(gw);", "return GW_DONE;"), "parameters-kept"),
    ("an order K that stores nothing and says so", 5, ("parameter->kept = parameter->value;", ""), "parameters-kept"),
    ("limits of parameters ignored", 5, ("message->value < parameter->least || message->value > parameter->most", "0"), "parameter-limits"),
    ("unknown parameters taken for done", 5, ("return GW_DONE;\n    }\n    return GW_UNKNOWN;", "return GW_DONE;\n    }\n    return GW_DONE;"), "parameter-unknown"),
    ("places beyond the table", 5, ("if (place > gw->parameter_count) {\n        return GW_BAD_VALUE;", "if (place > gw->parameter_count) {\n        return GW_DONE;"), "parameter-place"),
    ("layers without effect", 2, ("gw->allowed = (uint8_t)((gw->allowed & ~message->which) | message->allowed);", ""), "layers"),
    ("layers that the order does not name forbidden", 3, ("((gw->allowed & ~message->which) | message->allowed)", "(message->allowed)"), "layers"),
    ("layers that are allowed and never forbidden", 2, ("((gw->allowed & ~message->which) | message->allowed)", "(gw->allowed | message->allowed)"), "layers"),
    ("layers in the other order of bits", 3, ("((gw->allowed & ~message->which) | message->allowed)", "((gw->allowed & ~(message->which >> 1)) | message->allowed >> 1)"), "layers"),
    ("a layer that is not fitted allowed", 3, ("(message->allowed & ~gw->fitted) != 0", "0"), "layer-fitted"),
    ("session 0 after 7", 2, ("gw->session = gw->session % 7 + 1;", "gw->session = (gw->session + 1) & 7;"), "session-wrap"),
    ("an era that stands still", 2, ("gw->era = (gw->era + 1) & 0x3FFF;", ";"), "session-wrap"),
    ("a session that ends at 4", 2, ("gw->session = gw->session % 7 + 1;", "gw->session = gw->session % 4 + 1;"), "open"),
    ("a command's sequence of 3 bits", 2, ("message->sequence == ((gw->sequence + 1) & 63)", "message->sequence == ((gw->sequence + 1) & 7)"), "layers"),
    ("an order without a result", 2, ("gw->outcome = (uint8_t)execute(gw, message);", "gw->outcome = GW_FAILED;\n            (void)execute(gw, message);"), "command"),
    ("a receipt that stays in the next session", 2, ("gw->receipt = GW_NONE;\n#if GW_LEVEL >= 3", "#if GW_LEVEL >= 3"), "receipt-ends"),
    ("a buffer of 64 bytes", 3, ("length > GW_FRAME_BYTES || read_frame", "length > 64 || read_frame"), "long-frame"),
    ("a window that begins with the block that is missing", 3, ("has_block(gw, (uint16_t)(missing + 1 + n)) << n", "has_block(gw, (uint16_t)(missing + n)) << n"), "list-window"),
    ("a window with its bits in the other order", 3, ("has_block(gw, (uint16_t)(missing + 1 + n)) << n", "has_block(gw, (uint16_t)(missing + 1 + n)) << (7 - n)"), "list-window"),
    ("a window of the blocks from the first one", 3, ("has_block(gw, (uint16_t)(missing + 1 + n)) << n", "has_block(gw, n) << n"), "list-window"),
    ("waypoints at half the block", 3, ("&gw->banks[1 - gw->active_bank][first + n];", "&gw->banks[1 - gw->active_bank][first / 2 + n];"), "list"),
    ("a digest in the other order of bytes", 3, ("message->digest |= top << 30;", "message->digest |= top << 30;\n        message->digest = message->digest >> 24 | (message->digest >> 8 & 0xFF00) | (message->digest & 0xFF00) << 8 | message->digest << 24;"), "list"),
    ("a session that survives a reset", 2, ("memset(gw, 0, sizeof *gw);\n    gw->robot_id", "uint8_t session = gw->session;\n    memset(gw, 0, sizeof *gw);\n    gw->session = session;\n    gw->robot_id"), "boot-session"),
];

#[cfg(unix)]
#[test]
fn planted_faults_are_named_by_the_rule_that_they_break() {
    let named = on_all_cores(0..FAULTS.len() as u64, |n| {
        let (about, level, patch, code) = FAULTS[n as usize];
        let trials = tried_until(&mut InC::start(level, 0, &[patch]), |trials| {
            trials.is_over() || !broken(trials).is_empty()
        });
        let found = broken(&trials);
        (found.first() == Some(&code))
            .then_some(())
            .ok_or_else(|| format!("{about}: expected {code}, found {found:?}"))
    });
    let wrong: Vec<String> = named.into_iter().filter_map(|(_, it)| it.err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A board without memory for parameters breaks no rule.
#[cfg(unix)]
#[test]
fn a_robot_that_cannot_store_parameters_keeps_every_rule() {
    let patch = ("return keep_parameters(gw);", "return GW_NOT_FITTED;");
    let trials = tried(&mut InC::start(5, 0, &[patch]));
    assert_eq!(broken(&trials), [""; 0], "{:?}", trials.verdicts());
    assert_eq!(trials.level(), Some(5));
}

#[cfg(unix)]
#[test]
fn a_reset_that_is_not_counted_is_named() {
    let mut robot = InC::start(2, 0, &[]);
    robot.counts_boots = false;
    let trials = tried(&mut robot);
    assert_eq!(broken(&trials)[0], "boot", "{:?}", trials.verdicts());
    assert_eq!(trials.level(), Some(1));
}
