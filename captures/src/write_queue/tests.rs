use super::*;
use std::sync::mpsc::{Receiver, Sender, channel};

/// A worker that writes one item for each permission, and reports its actions.
struct Gated {
    permissions: Receiver<()>,
    deeds: Sender<String>,
}

impl FileWorker for Gated {
    type Item = &'static str;

    fn write(&mut self, item: &'static str) -> Result<(), CaptureError> {
        self.permissions.recv().unwrap();
        self.deeds.send(item.to_owned()).unwrap();
        Ok(())
    }

    fn look(&mut self) -> Result<(), CaptureError> {
        self.write("look")
    }

    fn finish(mut self) -> Result<(), CaptureError> {
        self.write("finish")
    }

    fn leave(mut self) {
        let _ = self.write("leave");
    }
}

fn gated() -> (WriteQueue<&'static str>, Sender<()>, Receiver<String>) {
    let (permit, permissions) = channel();
    let (deeds, done) = channel();
    let worker = Gated { permissions, deeds };
    let queue = WriteQueue::start("a.txt".into(), worker, Arc::default()).unwrap();
    (queue, permit, done)
}

#[test]
fn items_looks_and_the_end_come_in_order() {
    let (queue, permit, done) = gated();
    queue.push("one", 3, None);
    queue.look();
    queue.push("two", 3, None);
    for _ in 0..4 {
        permit.send(()).unwrap();
    }
    assert_eq!(queue.finish_within(PATIENCE).unwrap(), 6);
    let done: Vec<String> = done.iter().collect();
    assert_eq!(done, ["one", "look", "two", "finish"]);
}

/// A file with a full queue is given up; later items are counted but not written.
#[test]
fn a_full_queue_ends_the_file_at_an_exact_place() {
    let (queue, permit, done) = gated();
    queue.push("first", 2 * WAITING_MAX + 1, None);
    assert_eq!(queue.problem(), None);
    queue.push("second", 7, None);
    let problem = queue.problem().unwrap();
    assert!(problem.contains("accepts no bytes"), "{problem}");
    let error = queue.finish_within(Duration::ZERO).unwrap_err();
    assert!(
        error.to_string().contains("33554440 bytes are not in it"),
        "{error}"
    );
    permit.send(()).unwrap();
    permit.send(()).unwrap();
    let done: Vec<String> = done.iter().take(2).collect();
    assert_eq!(done, ["first", "finish"]);
}

/// The reader waits once for a file that hangs, and again only when the file has caught up.
#[test]
fn a_reader_is_delayed_once() {
    let (queue, permit, done) = gated();
    queue.push("much", 4, None);
    let is_late = || queue.shared.lock().is_late;
    queue.pace().wait();
    assert!(is_late());
    queue.push("more", 1, None);
    permit.send(()).unwrap();
    permit.send(()).unwrap();
    assert_eq!(done.iter().take(2).collect::<Vec<_>>(), ["much", "more"]);
    while queue.unwritten() > 0 {
        thread::yield_now();
    }
    queue.pace().wait();
    assert!(!is_late());
}

#[test]
fn a_disk_that_hangs_after_the_last_byte_is_reported() {
    let (queue, permit, done) = gated();
    queue.push("all", 3, None);
    permit.send(()).unwrap();
    assert_eq!(done.recv().unwrap(), "all");
    let error = loop {
        let error = queue.finish_within(Duration::ZERO).unwrap_err().to_string();
        if !error.contains("3 bytes") {
            break error;
        }
    };
    assert!(error.contains("does not confirm"), "{error}");
    permit.send(()).unwrap();
}
