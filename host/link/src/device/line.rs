//! A line to a device: a thread that does nothing but read, and a writer.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use shared::wire::{Accumulated, Accumulator, BAUD};

/// The reader looks so often whether it shall end.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A device that takes nothing for so long is gone.
const WRITING: Duration = Duration::from_secs(2);

/// Why there is no line.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum LineError {
    #[error("cannot be opened: {0}{advice}", advice = advice(.0))]
    Open(serialport::Error),
    #[error("the line is gone: {0}")]
    Gone(std::io::Error),
}

/// What helps against an error of the system.
fn advice(error: &serialport::Error) -> &'static str {
    match error.kind() {
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) if cfg!(target_os = "linux") => {
            "; on most systems the group `dialout` may open serial ports"
        }
        serialport::ErrorKind::NoDevice => "; is it plugged in, or in use by another program?",
        _ => "",
    }
}

/// What came out of the line.
#[derive(Debug)]
pub enum Arrival {
    /// A frame as it was on the line, without its zero byte.
    Frame(Instant, Vec<u8>),
    /// More bytes than a frame has, without a zero byte.
    TooLong(Instant),
    /// Nothing more will come.
    Gone(std::io::Error),
}

/// Frames that were read and not yet taken: a disk that is slow makes them more, and loses none.
#[derive(Debug, Default)]
pub struct Backlog {
    now: AtomicUsize,
    most: AtomicUsize,
}

impl Backlog {
    /// How many wait.
    #[must_use]
    pub fn now(&self) -> usize {
        self.now.load(Ordering::Relaxed)
    }

    /// How many ever waited.
    #[must_use]
    pub fn most(&self) -> usize {
        self.most.load(Ordering::Relaxed)
    }

    fn more(&self) {
        let now = self.now.fetch_add(1, Ordering::Relaxed) + 1;
        self.most.fetch_max(now, Ordering::Relaxed);
    }

    fn less(&self) {
        self.now.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A line to a device.
pub struct Line {
    writer: Box<dyn Write + Send>,
    arrivals: Receiver<Arrival>,
    backlog: Arc<Backlog>,
    ended: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
}

impl Line {
    /// Opens a serial port; nobody else can open it until this is dropped. The control lines stay as they are.
    ///
    /// # Errors
    /// [`LineError::Open`].
    pub fn open(path: &Path) -> Result<Self, LineError> {
        let port = |baud| {
            serialport::new(path.to_string_lossy(), baud)
                .timeout(POLL_INTERVAL)
                .preserve_dtr_on_open()
                .open()
        };
        // Over USB and pseudo-terminals the speed means nothing.
        let mut writer = match port(BAUD) {
            // There, a pseudo-terminal has no speed.
            Err(_) if cfg!(target_os = "macos") => port(0),
            opened => opened,
        }
        .map_err(LineError::Open)?;
        let reader = writer.try_clone().map_err(LineError::Open)?;
        // What came before the handshake is of no use; a port that cannot forget it is no worse.
        let _ = writer.clear(serialport::ClearBuffer::Input);
        writer.set_timeout(WRITING).map_err(LineError::Open)?;
        Ok(Self::over(reader, writer))
    }

    /// A line over anything that can be read and written. `reader` must give up with [`ErrorKind::TimedOut`] now and then;
    /// any other error, or no bytes, ends the line.
    pub fn over(reader: impl Read + Send + 'static, writer: impl Write + Send + 'static) -> Self {
        let (sender, arrivals) = channel();
        let backlog = Arc::new(Backlog::default());
        let ended = Arc::new(AtomicBool::new(false));
        let reading = (backlog.clone(), ended.clone());
        let reader = std::thread::spawn(move || {
            let gone = read_on(reader, &sender, &reading.0, &reading.1);
            // Nobody listens any more where this fails.
            let _ = sender.send(Arrival::Gone(gone));
        });
        Self { writer: Box::new(writer), arrivals, backlog, ended, reader: Some(reader) }
    }

    /// Sends bytes.
    ///
    /// # Errors
    /// [`LineError::Gone`].
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        self.writer.write_all(bytes).map_err(LineError::Gone)
    }

    /// The next that comes before `deadline`.
    ///
    /// # Errors
    /// [`LineError::Gone`] once all that came was taken.
    pub fn receive(&mut self, deadline: Instant) -> Result<Option<Arrival>, LineError> {
        match self.arrivals.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(Arrival::Gone(source)) => Err(LineError::Gone(source)),
            Ok(arrival) => {
                self.backlog.less();
                Ok(Some(arrival))
            }
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => {
                Err(LineError::Gone(ErrorKind::BrokenPipe.into()))
            }
        }
    }

    /// What waits to be received.
    #[must_use]
    pub fn backlog(&self) -> &Backlog {
        &self.backlog
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        // The port must be closed when this returns, so that it can be opened again.
        self.ended.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

/// Reads until the line is gone or nobody listens; why it ended.
fn read_on(
    mut reader: impl Read,
    sender: &Sender<Arrival>,
    backlog: &Backlog,
    ended: &AtomicBool,
) -> std::io::Error {
    let mut line = Accumulator::new();
    let mut bytes = [0; 4_096];
    while !ended.load(Ordering::Relaxed) {
        let length = match reader.read(&mut bytes) {
            Ok(0) => return ErrorKind::UnexpectedEof.into(),
            Ok(length) => length,
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => continue,
                _ => return error,
            },
        };
        let now = Instant::now();
        for byte in &bytes[..length] {
            let arrival = match line.push(*byte) {
                Accumulated::Nothing => continue,
                Accumulated::Frame(frame) => Arrival::Frame(now, frame.to_vec()),
                Accumulated::TooLong => Arrival::TooLong(now),
            };
            backlog.more();
            if sender.send(arrival).is_err() {
                return ErrorKind::BrokenPipe.into();
            }
        }
    }
    ErrorKind::BrokenPipe.into()
}
