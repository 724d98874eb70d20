//! One adapter's device: what it is, what it may take, whether it still lives, and how long anything
//! waits for it.
//!
//! wgpu's own ways to fail are gathered here: a lost device drops errors silently and may panic in
//! `poll`, an error without a scope would end the process, and the last handle of a queue waits for
//! work that never ends. Whoever works with a device sees a [`Failure`] instead.

use crate::progress::Interrupted;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::pin;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::task::{Context, Poll, Waker};
use std::thread::ThreadId;
use std::time::{Duration, Instant};
use wgpu::SubmissionIndex;

/// Bytes that all buffers and textures of a device may take together: drivers promise more than
/// there is.
const MOST_BYTES: u64 = 2 << 30;
/// Nothing waits longer for a device; for a driver in software, which compiles shaders for seconds and
/// shares its cores, a while longer.
const PATIENCE: [Duration; 2] = [Duration::from_secs(20), Duration::from_secs(120)];
/// A wait looks up this often.
const GLANCE: Duration = Duration::from_millis(50);

/// Why a device has no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// There is no such adapter.
    #[error("no {0} adapter")]
    Absent(&'static str),
    /// The device is gone.
    #[error("the device was lost")]
    Lost,
    /// It did not answer in time.
    #[error("the device did not answer in time")]
    Silent,
    /// What is asked for takes more memory than the device may have, or than it has.
    #[error("the device has no {0} bytes left")]
    Memory(u64),
    /// It refused something that should be valid.
    #[error("the device refused: {0}")]
    Refused(String),
    /// The caller asked to stop.
    #[error("stopped")]
    Interrupted,
}

impl From<Interrupted> for Failure {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// How far a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// A pipeline is about to be made.
    Pipeline,
    /// What the passes read is on its way to the device.
    Upload,
    /// The passes were submitted.
    Dispatch,
    /// The picture is about to be read.
    Map,
}

/// Which adapters will do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// A processor made for it.
    Hardware,
    /// That, else a driver in software.
    Any,
}

/// An open device.
#[derive(Debug)]
pub struct Device {
    /// Its adapter's name and driver.
    pub info: wgpu::AdapterInfo,
    /// Makes things.
    pub handle: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    lost: Arc<AtomicBool>,
    /// What it refused, and the thread that asked for it.
    refused: Arc<Mutex<Vec<(ThreadId, Failure)>>>,
    taken: Arc<AtomicU64>,
    /// Where the device's life ends; for tests.
    #[cfg(test)]
    pub doom: Mutex<Option<Stage>>,
}

/// Bytes that count against a device as long as this lives.
#[derive(Debug)]
pub struct Share {
    taken: Arc<AtomicU64>,
    bytes: u64,
}

impl Drop for Share {
    fn drop(&mut self) {
        self.taken.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// A buffer and its share of the memory.
#[derive(Debug)]
pub struct Buffer {
    /// The buffer.
    pub handle: wgpu::Buffer,
    _share: Share,
}

/// A texture, looked at as a whole, and its share of the memory.
#[derive(Debug)]
pub struct Texture {
    /// The texture.
    pub handle: wgpu::Texture,
    /// All of it.
    pub view: wgpu::TextureView,
    _share: Share,
}

/// The adapters of this machine, hardware first.
pub fn adapters() -> Vec<wgpu::Adapter> {
    let descriptor = wgpu::InstanceDescriptor {
        backends: wgpu::Backends::VULKAN,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    };
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = now(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
}

impl Device {
    /// Opens the best adapter.
    ///
    /// # Errors
    /// Where there is none, or it cannot add up in floats.
    pub fn open(wanted: Wanted) -> Result<Self, Failure> {
        let adapter = adapters().into_iter().next();
        let will_do = |adapter: &wgpu::Adapter| {
            wanted == Wanted::Any || adapter.get_info().device_type != wgpu::DeviceType::Cpu
        };
        let name = if wanted == Wanted::Any { "Vulkan" } else { "hardware" };
        Self::of(&adapter.filter(will_do).ok_or(Failure::Absent(name))?)
    }

    /// Opens an adapter.
    ///
    /// # Errors
    /// Where it cannot add up in floats, or gives no device.
    pub fn of(adapter: &wgpu::Adapter) -> Result<Self, Failure> {
        let descriptor = wgpu::DeviceDescriptor {
            label: None,
            // Thousands of blobs are added up in a target; clocks are welcome.
            required_features: wgpu::Features::FLOAT32_BLENDABLE
                | adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let opened = now(adapter.request_device(&descriptor));
        let (handle, queue) = opened.map_err(|error| Failure::Refused(error.to_string()))?;
        let lost = Arc::new(AtomicBool::new(false));
        let refused = Arc::new(Mutex::new(Vec::new()));
        let (flag, slot) = (Arc::clone(&lost), Arc::clone(&refused));
        handle.set_device_lost_callback(move |_, _| flag.store(true, Ordering::SeqCst));
        handle.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let failure = match error {
                wgpu::Error::OutOfMemory { .. } => Failure::Memory(0),
                other => Failure::Refused(other.to_string()),
            };
            let mut refused = slot.lock().unwrap_or_else(PoisonError::into_inner);
            refused.push((std::thread::current().id(), failure));
        }));
        let info = adapter.get_info();
        Ok(Self {
            info,
            handle,
            queue,
            lost,
            refused,
            taken: Arc::default(),
            #[cfg(test)]
            doom: Mutex::default(),
        })
    }

    /// Whether it runs on a processor made for it.
    pub fn is_hardware(&self) -> bool {
        self.info.device_type != wgpu::DeviceType::Cpu
    }

    /// What went wrong since this thread's last look.
    ///
    /// # Errors
    /// The first failure.
    pub fn look(&self) -> Result<(), Failure> {
        if self.lost.load(Ordering::SeqCst) {
            return Err(Failure::Lost);
        }
        let own = std::thread::current().id();
        let mut refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
        let mut failures = refused.extract_if(.., |(thread, _)| *thread == own).collect::<Vec<_>>();
        if failures.is_empty() { Ok(()) } else { Err(failures.swap_remove(0).1) }
    }

    fn share(&self, bytes: u64) -> Result<Share, Failure> {
        let before = self.taken.fetch_add(bytes, Ordering::Relaxed);
        let share = Share { taken: Arc::clone(&self.taken), bytes };
        if before + bytes > MOST_BYTES { Err(Failure::Memory(bytes)) } else { Ok(share) }
    }

    /// Bytes that its buffers and textures take.
    pub fn bytes(&self) -> u64 {
        self.taken.load(Ordering::Relaxed)
    }

    /// A buffer, counted before it is made.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub fn buffer(&self, size: u64, usage: wgpu::BufferUsages) -> Result<Buffer, Failure> {
        let limits = self.handle.limits();
        let is_storage = usage.contains(wgpu::BufferUsages::STORAGE);
        if size > limits.max_buffer_size
            || is_storage && size > limits.max_storage_buffer_binding_size
        {
            return Err(Failure::Memory(size));
        }
        let share = self.share(size)?;
        let descriptor =
            wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let buffer = Buffer { handle: self.handle.create_buffer(&descriptor), _share: share };
        self.look().map(|()| buffer)
    }

    /// A buffer with content.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub fn filled(&self, bytes: &[u8], usage: wgpu::BufferUsages) -> Result<Buffer, Failure> {
        let buffer = self.buffer(bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST)?;
        self.queue.write_buffer(&buffer.handle, 0, bytes);
        Ok(buffer)
    }

    /// Lists of numbers that shaders read, one after the other.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn joined<'a>(
        &self,
        lists: impl Iterator<Item = &'a [f32]> + Clone,
    ) -> Result<Buffer, Failure> {
        let count = lists.clone().map(<[f32]>::len).sum::<usize>().max(1);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = self.buffer(4 * count as u64, usage)?;
        let mut at = 0;
        for list in lists {
            let bytes: &[u8] = bytemuck::cast_slice(list);
            self.queue.write_buffer(&buffer.handle, at, bytes);
            at += bytes.len() as u64;
        }
        Ok(buffer)
    }

    /// A target that shaders read later on.
    ///
    /// # Errors
    /// Where it is too large.
    pub fn target(
        &self,
        width: u32,
        height: u32,
        format: wgpu::TextureFormat,
    ) -> Result<Texture, Failure> {
        let most = self.handle.limits().max_texture_dimension_2d;
        let texel = u64::from(format.block_copy_size(None).unwrap_or(4));
        let bytes = u64::from(width) * u64::from(height) * texel;
        if width > most || height > most {
            return Err(Failure::Memory(bytes));
        }
        let share = self.share(bytes)?;
        let handle = self.handle.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = handle.create_view(&wgpu::TextureViewDescriptor::default());
        self.look().map(|()| Texture { handle, view, _share: share })
    }

    /// A frame is so far.
    pub fn reached(&self, stage: Stage) {
        tracing::trace!("{stage:?}");
        #[cfg(test)]
        if *self.doom.lock().unwrap_or_else(PoisonError::into_inner) == Some(stage) {
            self.handle.destroy();
        }
    }

    /// Starts to work on commands.
    ///
    /// # Errors
    /// Where the device is lost or refuses.
    pub fn submit(&self, commands: wgpu::CommandBuffer) -> Result<SubmissionIndex, Failure> {
        let submission = self.queue.submit([commands]);
        self.reached(Stage::Dispatch);
        self.look().map(|()| submission)
    }

    /// Waits until commands are done.
    ///
    /// # Errors
    /// Where the device is lost, refuses, or stays silent.
    pub fn finish(&self, submission: &SubmissionIndex) -> Result<(), Failure> {
        let end = Instant::now() + PATIENCE[usize::from(!self.is_hardware())];
        while !self.poll(submission)? {
            if Instant::now() > end {
                return Err(Failure::Silent);
            }
        }
        Ok(())
    }

    /// Waits until a buffer that a submission fills can be read.
    ///
    /// # Errors
    /// Where the device is lost, refuses, or stays silent.
    pub fn read(
        &self,
        submission: &SubmissionIndex,
        staging: &wgpu::Buffer,
    ) -> Result<wgpu::BufferView, Failure> {
        let (sender, mapped) = mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody listens any more after a timeout.
            let _ = sender.send(result);
        });
        self.reached(Stage::Map);
        self.finish(submission)?;
        // A submission that is done calls back, maybe from another thread that waits.
        match mapped.recv_timeout(PATIENCE[0]) {
            Ok(Ok(())) => staging.get_mapped_range(..).map_err(|_| Failure::Lost),
            _ => Err(Failure::Lost),
        }
    }

    /// Waits a moment for a submission; whether it is done.
    fn poll(&self, submission: &SubmissionIndex) -> Result<bool, Failure> {
        let wait = wgpu::PollType::Wait {
            submission_index: Some(submission.clone()),
            timeout: Some(GLANCE),
        };
        // A device that is lost during the wait panics there.
        let polled = catch_unwind(AssertUnwindSafe(|| self.handle.poll(wait)));
        match polled {
            Ok(Ok(_)) => self.look().map(|()| true),
            Ok(Err(wgpu::PollError::Timeout)) => self.look().map(|()| false),
            Ok(Err(_)) | Err(_) => Err(Failure::Lost),
        }
    }

    /// Leaves a device that does not answer: its queue must not be waited for.
    pub fn abandon(&self) {
        std::mem::forget(self.queue.clone());
    }
}

/// wgpu's futures are ready at once on native targets.
fn now<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        std::thread::yield_now();
    }
}
