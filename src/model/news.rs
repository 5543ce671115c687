//! What became of the operator's last wish, while that is news.

use super::{Shown, Ui, ledger, log};
use crate::event::Moment;

/// What is told where everybody looks.
#[derive(Clone, Copy, Debug)]
pub(crate) enum News<'a> {
    /// A command went a step further.
    Command(&'a ledger::Entry),
    /// The station had something to say, or the robot raised an alarm.
    Logged(&'a log::Entry),
    /// Something about the keys.
    Passing(&'a Passing),
}

/// What is told once about the keys and is not worth a line in the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Passing {
    /// Another panel was chosen: which there are.
    Panels,
    /// These words.
    Words(String),
}

/// How long something is news.
const NEWS_FOR: Moment = Moment::from_secs(5);

impl Ui {
    /// Shows feedback to a key.
    pub(super) fn pass_on(&mut self, now: Moment, what: Passing) {
        self.passing = Some((now, what));
    }
}

impl<'a> Shown<'a> {
    /// What is news now.
    pub(crate) fn news(&self, now: Moment) -> Option<News<'a>> {
        let (at, news) = self.newest()?;
        (now < at + NEWS_FOR).then_some(news)
    }

    /// When what is news now no longer is.
    pub(super) fn news_until(&self, now: Moment) -> Option<Moment> {
        let (at, _) = self.newest()?;
        Some(at + NEWS_FOR).filter(|until| *until > now)
    }

    fn newest(&self) -> Option<(Moment, News<'a>)> {
        let command = self.facts.ledger.newest();
        let command = command.map(|entry| (entry.at, News::Command(entry)));
        let logged = self.facts.log.newest_first().find(|entry| entry.is_news());
        let logged = logged.map(|entry| (entry.at, News::Logged(entry)));
        let passing = self.ui.passing.as_ref();
        let passing = passing.map(|(at, what)| (*at, News::Passing(what)));
        // A wish that is older than a word of the station's is not about it.
        command
            .into_iter()
            .chain(logged)
            .chain(passing)
            .max_by_key(|(at, _)| *at)
    }
}
