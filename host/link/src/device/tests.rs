//! Conversations with a device that follows a script.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use shared::pipeline::GAUGES;
use shared::wire::{
    Accumulated, Accumulator, Answer, ClockSource, Columns, Counters, Done, FRAME_MAX, Formats,
    Head, Hello, Refusal, ResetCause, SCHEMA, Settings, Status, ToDevice, ToHost, decode, encode,
    introduction, open, read,
};

use super::heard::Said;
use super::line::{Arrival, Line};
use super::replay::replay;
use super::session::{LinkError, Session, VERSION};

/// How long an answer that comes may take: on a busy machine, longer than anybody would wait.
const SOON: Duration = Duration::from_secs(20);

/// One end of a line in memory.
struct End {
    to: Sender<Vec<u8>>,
    from: Option<Receiver<Vec<u8>>>,
    read: VecDeque<u8>,
}

/// A line in memory, from end to end.
fn ends() -> (End, End) {
    let ((to_b, from_a), (to_a, from_b)) = (channel(), channel());
    let end = |to, from| End { to, from: Some(from), read: VecDeque::new() };
    (end(to_b, from_b), end(to_a, from_a))
}

impl Write for End {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.to.send(bytes.to_vec()).map_err(|_| ErrorKind::BrokenPipe)?;
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Read for End {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.read.is_empty() {
            let from = self.from.as_ref().ok_or(ErrorKind::BrokenPipe)?;
            match from.recv_timeout(Duration::from_millis(10)) {
                Ok(more) => self.read.extend(more),
                Err(RecvTimeoutError::Timeout) => return Err(ErrorKind::TimedOut.into()),
                Err(RecvTimeoutError::Disconnected) => return Ok(0),
            }
        }
        self.read.read(bytes)
    }
}

/// A line whose other end is the device's.
fn line() -> (Line, End) {
    let (mut near, far) = ends();
    let writer = End { to: near.to.clone(), from: None, read: VecDeque::new() };
    near.to = channel().0;
    (Line::over(near, writer), far)
}

/// What a device does with a frame: its number, its message, and the bytes to send.
type Script = Box<dyn FnMut(u32, &[u8], &mut Vec<u8>) + Send>;

/// A device that follows a script until the host is gone.
fn device(mut end: End, mut script: Script) -> JoinHandle<()> {
    std::thread::spawn(move || {
        let (mut line, mut bytes) = (Accumulator::new(), [0; 512]);
        loop {
            let length = match end.read(&mut bytes) {
                Ok(0) => return,
                Ok(length) => length,
                Err(error) if error.kind() == ErrorKind::TimedOut => continue,
                Err(_) => return,
            };
            for byte in &bytes[..length] {
                if let Accumulated::Frame(frame) = line.push(*byte) {
                    let (head, message) = open(frame).unwrap();
                    let mut out = Vec::new();
                    script(head.sequence, message, &mut out);
                    if !out.is_empty() && end.write(&out).is_err() {
                        return;
                    }
                }
            }
        }
    })
}

fn say(message: &ToHost<'_>, out: &mut Vec<u8>) {
    let mut frame = [0; FRAME_MAX];
    out.extend(encode(Head::default(), message, &mut frame).unwrap());
}

fn hello(schema: u64, version: &str, out: &mut Vec<u8>) {
    hello_of(schema, version, 4, out);
}

/// Of a device with so many gauges.
fn hello_of(schema: u64, version: &str, channels: u8, out: &mut Vec<u8>) {
    say(
        &ToHost::Hello(Hello {
            schema,
            version,
            git: "",
            board: "script",
            serial: [1, 2, 3],
            channels,
            converter_clock_hz: 8_000_000,
            clock: ClockSource::Crystal,
            formats: Formats::OURS,
            reset: ResetCause::PowerOn,
            panic: "",
            counters: Counters::default(),
        }),
        out,
    );
}

fn answer(to: u32, outcome: Result<Done, Refusal>, out: &mut Vec<u8>) {
    say(&ToHost::Answer(Answer { to, outcome }), out);
}

fn greet(to: u32, out: &mut Vec<u8>) {
    hello(SCHEMA, "1.0.0", out);
    say(&ToHost::Settings { generation: 0, settings: Settings::DEFAULT }, out);
    answer(to, Ok(Done::Carried), out);
}

/// A session with a device that greets, then does with each command what `script` says.
fn session(script: Script) -> Session {
    let (line, far) = line();
    session_over(line, far, script)
}

fn session_over(line: Line, far: End, mut script: Script) -> Session {
    device(
        far,
        Box::new(move |number, message, out| match introduction(message) {
            Some(_) => greet(number, out),
            None => script(number, message, out),
        }),
    );
    Session::over(line, SOON).unwrap()
}

#[test]
fn the_host_says_its_schema_and_version_and_learns_who_the_device_is() {
    let (line, far) = line();
    let (heard, asked) = channel();
    device(
        far,
        Box::new(move |number, message, out| {
            let who = introduction(message).unwrap();
            heard.send((who.schema, who.version.to_owned())).unwrap();
            greet(number, out);
        }),
    );
    let session = Session::over(line, SOON).unwrap();
    assert_eq!(asked.recv().unwrap(), (SCHEMA, VERSION.to_owned()));
    assert_eq!(session.identity().serial_number(), "000000010000000200000003");
    assert_eq!(session.settings(), (0, &Settings::DEFAULT));
}

#[test]
fn a_hello_that_is_lost_is_said_again() {
    let (line, far) = line();
    let mut lost = 1;
    device(
        far,
        Box::new(move |number, _, out| {
            if lost > 0 {
                lost -= 1;
                // Only half of the greeting arrives.
                return answer(number, Ok(Done::Carried), out);
            }
            greet(number, out);
        }),
    );
    assert!(Session::over(line, SOON).is_ok());
}

#[test]
fn a_device_with_more_gauges_than_the_program_reads_is_refused_with_both_numbers() {
    let (line, far) = line();
    device(far, Box::new(move |_, _, out| hello_of(SCHEMA, "1.0.0", 8, out)));
    let refused = Session::over(line, SOON).map(drop).unwrap_err().to_string();
    assert!(refused.starts_with("the device has 8 gauges") && refused.ends_with("reads up to 4"));
}

#[test]
fn another_schema_is_refused_with_both_versions_and_schemas() {
    for hears_hello in [true, false] {
        let (line, far) = line();
        device(
            far,
            Box::new(move |number, _, out| {
                if hears_hello {
                    hello(7, "9.8.7", out);
                }
                answer(number, Err(Refusal::Schema(7)), out);
            }),
        );
        let refused = Session::over(line, SOON).map(drop).unwrap_err().to_string();
        let theirs = if hears_hello { "firmware 9.8.7" } else { "firmware of unknown version" };
        let ours = format!("{VERSION} with schema {SCHEMA:#018x}");
        for part in [theirs, "0x0000000000000007", &ours] {
            assert!(refused.contains(part), "{refused}");
        }
    }
}

#[test]
fn a_port_where_nothing_answers_is_silent_and_noise_is_told_apart() {
    let (line, far) = line();
    device(far, Box::new(|_, _, _| {}));
    let silent = Session::over(line, Duration::from_millis(300)).map(drop);
    assert!(matches!(silent, Err(LinkError::Silent { damaged: 0 })));
    let (line, far) = self::line();
    device(far, Box::new(|_, _, out| out.extend(b"login: \0")));
    let noisy = Session::over(line, Duration::from_millis(300)).map(drop);
    assert!(matches!(noisy, Err(LinkError::Silent { damaged: 1.. })));
}

#[test]
fn a_command_without_answer_is_sent_again_with_the_same_number() {
    let (numbers, seen) = channel();
    let mut lost = 2;
    let mut session = session(Box::new(move |number, message, out| {
        numbers.send((number, message.to_vec())).unwrap();
        if lost > 0 {
            lost -= 1;
            return;
        }
        answer(number, Ok(Done::Carried), out);
    }));
    assert_eq!(session.command(&ToDevice::Tare).unwrap(), Done::Carried);
    let seen: Vec<_> = seen.try_iter().collect();
    assert_eq!(seen.len(), 3);
    assert!(seen.iter().all(|frame| *frame == seen[0]));
}

#[test]
fn the_answer_to_an_earlier_command_is_not_taken_for_this_one() {
    let mut session = session(Box::new(|number, _, out| {
        answer(number.wrapping_sub(1), Ok(Done::Carried), out);
        answer(number, Err(Refusal::Streaming), out);
    }));
    let refused = session.command(&ToDevice::Save).unwrap_err();
    assert!(matches!(refused, LinkError::Refused(_)));
    assert!(refused.to_string().contains("stop the recording first"), "{refused}");
}

#[test]
fn what_comes_while_a_command_waits_is_heard_afterwards_in_order() {
    let mut session = session(Box::new(|number, _, out| {
        for generation in 1..=3 {
            say(&ToHost::Settings { generation, settings: Settings::DEFAULT }, out);
        }
        answer(number, Ok(Done::Carried), out);
    }));
    session.forget();
    session.command(&ToDevice::Tare).unwrap();
    assert_eq!(session.settings().0, 3);
    let mut generations = Vec::new();
    while let Some(heard) = session.hear(Instant::now()).unwrap() {
        if let Ok((_, Said::Settings(generation, _))) = heard.said {
            generations.push(generation);
        }
    }
    assert_eq!(generations, [1, 2, 3]);
}

#[test]
fn rows_that_do_not_come_are_not_waited_for_because_a_device_goes_on_talking() {
    let (line, far) = line();
    let (talker, mut said) = (far.to.clone(), Vec::new());
    say(&ToHost::Status(Status::default()), &mut said);
    let talking = std::thread::spawn(move || {
        for _ in 0..200 {
            if talker.send(said.clone()).is_err() {
                return false;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        true
    });
    let lose = |number, message: &[u8], out: &mut Vec<u8>| {
        let outcome = match read(message).unwrap() {
            ToDevice::Inject(_) => Done::Injected { taken: 1, lost: 0, room: 15 },
            _ => Done::Carried,
        };
        answer(number, Ok(outcome), out);
        say(&ToHost::Status(Status::default()), out);
    };
    let mut session = session_over(line, far, Box::new(lose));
    let replayed = replay(&mut session, 1_000_000, Columns::Parts, None, &[[1; GAUGES]]).unwrap();
    assert!(replayed.rows.is_empty());
    drop(session);
    assert!(!talking.join().unwrap(), "it was heard to its end");
}

#[test]
fn a_host_that_is_slow_loses_nothing_and_knows_how_far_behind_it_is() {
    let (mut line, mut far) = line();
    let mut frame = [0; FRAME_MAX];
    for sequence in 0..5_000 {
        let head = Head { sequence, time_us: 0 };
        let settings = ToHost::Settings { generation: 0, settings: Settings::DEFAULT };
        far.write_all(encode(head, &settings, &mut frame).unwrap()).unwrap();
    }
    let until = Instant::now() + Duration::from_secs(20);
    while line.backlog().now() < 5_000 && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(line.backlog().most(), 5_000);
    for sequence in 0..5_000 {
        let Ok(Some(Arrival::Frame(_, mut frame))) = line.receive(until) else { panic!() };
        assert_eq!(decode::<ToHost<'_>>(&mut frame).unwrap().0.sequence, sequence);
    }
    assert_eq!(line.backlog().now(), 0);
    drop(far);
    assert!(line.receive(until).is_err());
}
