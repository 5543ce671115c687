//! The rules tried: stable code, rule, likely cause of a breach, and remedy.

/// A rule of SPEC.md that is tried on a robot.
#[derive(Debug, PartialEq, Eq)]
pub struct Rule {
    /// Stable code.
    pub code: &'static str,
    /// Lowest level that the rule binds.
    pub level: u8,
    /// Section of SPEC.md that contains the rule.
    pub section: u8,
    /// The rule as a sentence.
    pub rule: &'static str,
    /// Likely cause of a breach.
    pub cause: &'static str,
    /// Remedy.
    pub remedy: &'static str,
}

macro_rules! rules {
    ($($name:ident = $code:literal, $level:literal, $section:literal, $rule:literal, $cause:literal, $remedy:literal;)*) => {
        $(pub(super) const $name: &Rule = &Rule { code: $code, level: $level, section: $section, rule: $rule, cause: $cause, remedy: $remedy };)*

        /// All rules.
        pub const ALL: &[&Rule] = &[$($name),*];
    };
}

rules! {
    STOP = "stop", 2, 11, "STOP stops the robot", "frames do not arrive, or STOP is checked with another key than the robot's id", "obey frame X in every state, under the robot's key and under key 0";
    STOP_RECEIPT = "stop-receipt", 2, 11, "the acknowledgement shows the receipt of the latest STOP", "the receipt is not kept, or its bits are misplaced", "keep the 15 bits and show them with bits 17, 16 and 15 set";
    STOP_MODE = "stop-mode", 2, 11, "the mode is X after STOP", "STOP is acknowledged and not carried out", "switch the motors off and set the mode before the next line";
    STOP_AGAIN = "stop-again", 2, 11, "every STOP shows in the acknowledgement", "the sequence does not count STOPs while no session is open", "count the sequence up by 1 at each STOP without a session";
    STOP_ANY = "stop-any", 2, 9, "STOP under key 0 stops every robot", "only the robot's own key is tried", "check frame X with the robot's key, then with 0";
    OPEN_STALE = "open-stale", 2, 11, "an open for another boot, session or era has no effect", "boot, session and era of the frame are not compared", "open a session only if all of them are the present ones";
    OPEN = "open", 2, 11, "an open for the present boot, session and era opens the next session", "the frame's parts are read at the wrong bits, or its key is not that of the robot's id", "compare with the frames O of vectors/frames-3.jsonl";
    OPEN_ERA = "open-era", 2, 11, "an open may name the era", "only the short form of the frame is read", "read 3 characters more: 4 zeros, the era";
    KEY = "session-key", 2, 9, "the key of the session has robot id, boot, session, owner and era", "a part of the key is missing or misplaced", "compare it with the table of section 9";
    COMMAND = "command", 2, 11, "a command is taken and acknowledged", "the frame is read at the wrong bits, or the checksum starts from another value", "compare with the frames C of vectors/frames.jsonl";
    MODE = "mode", 2, 11, "an order M enters the mode", "the order is acknowledged and not carried out", "report the mode in column 61 of line A";
    REPEATED = "repeated-command", 2, 11, "a command that comes again has no effect", "the sequence of commands is not compared", "take a command only if its sequence is one more than the latest";
    GAP = "command-gap", 2, 11, "a command after a gap in the sequence has no effect", "every new sequence is taken", "take a command only if its sequence is one more than the latest";
    WRONG_SESSION = "wrong-session", 2, 9, "a frame of an earlier session has no effect", "the key of an earlier session is taken, too", "take the key of the open session and no other";
    WRONG_OWNER = "wrong-owner", 2, 9, "a frame of another station has no effect", "the key of another owner is taken, too", "take the key of the open session and no other";
    WRONG_BOOT = "wrong-boot", 2, 9, "a frame from before a reboot has no effect", "the key of another boot is taken, too", "take the key of the open session and no other";
    WRONG_ROBOT = "wrong-robot", 2, 9, "a frame for another robot has no effect", "the key of another robot is taken, too", "take the key of the open session and no other";
    DAMAGED = "damaged-frame", 2, 9, "a damaged frame has no effect", "the checksum is not verified, or only a part of it", "compare all four characters before anything else is read";
    UNKNOWN_ORDER = "unknown-order", 2, 9, "an unknown order is refused with outcome 6", "the frame is dropped, or the order taken for another one", "take its sequence and answer 6";
    UNREADABLE_ORDER = "unreadable-order", 2, 9, "an unreadable order is refused with outcome 6", "the frame is dropped, or the order's length is not checked", "take its sequence and answer 6";
    BEYOND_LEVEL = "beyond-level", 2, 1, "an order beyond the level is refused with outcome 6", "the frame is dropped, or the level of line I is too low", "answer 6 to orders that the level lacks";
    NOT_FITTED = "not-fitted", 2, 11, "a mode that is not fitted is refused with outcome 1", "the mode is not compared with those fitted", "refuse modes that line I does not name";
    LAYERS = "layers", 2, 11, "an order L allows and forbids layers", "the order has no effect, or one on layers that it does not name", "leave the layers outside which as they are, and set those in it";
    STOP_SESSION = "stop-session", 2, 11, "STOP ends the session", "STOP leaves session or owner as they are", "begin a new session without an owner at STOP";
    RECEIPT_ENDS = "receipt-ends", 2, 11, "a new session has no receipt", "the receipt of the latest STOP is still shown in it", "clear the receipt when a session opens";
    SESSION_WRAP = "session-wrap", 2, 11, "session 1 follows session 7, in the next era", "the session is counted modulo 8, or the era stands still", "session modulo 7 + 1; count the era up when the session was 7";
    LAYER_FITTED = "layer-fitted", 3, 11, "a layer that is not fitted is refused with outcome 1", "the layer is not compared with those fitted", "refuse layers that line B shows as not fitted";
    LIST = "list", 3, 11, "a list is staged, verified and made the active one", "waypoints are read at the wrong bits, or the digest differs", "compare with section 10, vectors/digests.jsonl and the frames W of vectors/frames.jsonl";
    LIST_STATUS = "list-status", 3, 5, "line B shows the active list", "line B shows another count or digest than the list made active", "send line B with count and digest of the active list, soon after they change";
    LIST_MISSING = "list-missing", 3, 11, "a list with missing waypoints is refused with outcome 3", "order A does not look which blocks have arrived", "mark each block, and require all up to the count";
    LIST_WINDOW = "list-window", 3, 6, "the acknowledgement shows which blocks have arrived", "the window begins with another block, or its bits are in another order", "set bit n when block first missing + 1 + n has arrived";
    LONG_FRAME = "long-frame", 3, 9, "a frame of 87 bytes is taken", "the receiver's buffer is too short", "keep 87 bytes between two line feeds";
    LIST_DIGEST = "list-digest", 3, 11, "a list with another digest is refused with outcome 4", "order A does not compare the digest", "compute the digest over the staged list and compare all 32 bits";
    SHORT_BLOCK = "short-block", 3, 11, "a list with a short block that is not the last is refused with outcome 4", "the digest is computed over fewer waypoints than the count", "compute it over the first count waypoints of the bank";
    LIST_CAPACITY = "list-capacity", 3, 11, "a list beyond the capacity is refused with outcome 2", "the count is not compared with the capacity", "answer 2 before anything is copied";
    LIST_KEPT = "list-kept", 3, 11, "a list that is refused leaves the active one", "waypoints are written into the active bank", "keep two banks and swap them at outcome 0";
    LIST_TAG = "list-tag", 3, 11, "waypoints of a list already active have no effect", "the tag is not compared with the latest one", "open a list only for a tag 1 to 15 ahead of the latest";
    LIST_CLEAR = "list-clear", 3, 11, "a count of 0 clears the list", "the empty list is refused, or its digest is not 0x41D912FF", "clear both lists if the digest is that of the empty list";
    KNOCK = "knock", 4, 7, "a line feed brings lines K", "lines K come only with frames, or never", "send three lines K after each of the four long lines after a line feed";
    ACK_FRESH = "ack-fresh", 4, 6, "the acknowledgement is taken just before column 70", "it is taken when the line begins", "take it just before its first character is sent";
    HEARD = "heard", 4, 5, "line C counts the frames heard", "the counter is not kept", "count intact frames at columns 44-46";
    POSE = "pose", 4, 11, "an order P sets the pose", "the pose is acknowledged and not set", "report it in line A, and clear the odometer";
    REPEATED_POSE = "repeated-pose", 4, 11, "an order P that comes again is not carried out again", "the sequence of commands is not compared", "take a command only if its sequence is one more than the latest";
    DRIVE = "drive", 4, 11, "a fresh drive frame is obeyed", "the ground is not taken for live, or the line named not for recent", "compare with section 11: live for 2 s, the latest 16 lines, 1.2 s";
    DRIVE_END = "drive-end", 4, 11, "hand drive ends a second after the latest frame", "the time of the latest frame is not watched", "stand still a second after the latest drive frame";
    DRIVE_STALE = "drive-stale", 4, 11, "a drive frame that names an old line has no effect", "the age of the line named is not checked", "obey only frames that name one of the latest 16 lines, at most 1.2 s old";
    DRIVE_REPEATED = "drive-repeated", 4, 11, "a drive frame that comes again has no effect", "the count is not compared", "obey only counts 1 to 7 ahead of the latest, modulo 16";
    DRIVE_LIVE = "drive-live", 4, 11, "a drive frame has no effect unless the ground is live", "the rule of the 2 s is missing", "obey drive frames for 2 s after an open, a keepalive or a drive frame";
    DRIVE_STOPPED = "drive-stopped", 4, 11, "a drive frame has no effect in mode stop", "the mode is not checked", "ignore drive frames in mode X";
    FAILSAFE_RANGE = "failsafe-range", 4, 11, "a failsafe below 10 s is refused with outcome 2", "the silence is not checked", "refuse silences below 10 s";
    FAILSAFE_ARMED = "failsafe-armed", 4, 5, "column 59 shows that a failsafe is armed", "the letter is not set", "send f while a failsafe is set and a session is open";
    FAILSAFE = "failsafe", 4, 11, "the failsafe acts after its silence", "the silence is not counted from the latest intact frame", "enter the mode of the order, and send F in column 59";
    FAILSAFE_END = "failsafe-end", 4, 11, "an order M ends a failsafe that acts", "the failsafe goes on, or ends by itself", "end it at an order M or STOP, and at nothing else";
    PARAMETERS = "parameters", 5, 11, "an order N brings the lines P", "lines P are not sent, or not all", "send the line P of every place once";
    PARAMETER_SET = "parameter-set", 5, 11, "an order V sets a parameter and brings its line P", "the key does not match: it is the CRC-24 of the name from 0xFFFFFF", "compare the key with that of top-speed in section 9";
    PARAMETERS_KEPT = "parameters-kept", 5, 11, "an order K stores the values and brings lines P of those that changed", "the order has no effect, or the stored value is not reported", "write the values to memory that survives a reset, and report them in line P";
    PARAMETER_LIMITS = "parameter-limits", 5, 11, "a value beyond the limits is refused with outcome 2", "the limits of line P are not checked", "refuse the value and change nothing";
    PARAMETER_UNKNOWN = "parameter-unknown", 5, 11, "a parameter that is not there is refused with outcome 6", "the key is not compared in full", "compare all 24 bits";
    PARAMETER_PLACE = "parameter-place", 5, 11, "a place beyond the table is refused with outcome 2", "the place is not checked", "answer 2 to a place above the number of parameters";
    BOOT = "boot", 2, 11, "a reboot changes the boot counter", "the boot counter does not survive a reset", "keep it in memory that survives, or draw all 16 bits at random";
    BOOT_SESSION = "boot-session", 2, 11, "no session is open after a reboot", "session, owner or sequence survive the reset", "begin with session 0, no owner and sequence 0";
    BOOT_OPEN = "boot-open", 2, 11, "an open from before a reboot has no effect", "the boot of the frame is not compared", "open a session only for the present boot, session and era";
}
