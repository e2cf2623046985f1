//! Calls of Vulkan that fail on request. A library stands between the program and the loader; two files beside it say which call is to
//! fail, and which calls there were.

use std::fs;
use std::path::{Path, PathBuf};

use super::{Project, before_vulkan};

/// The answer of a call instead of its work (`VkResult`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// `VK_ERROR_OUT_OF_HOST_MEMORY`.
    HostMemory = -1,
    /// `VK_ERROR_OUT_OF_DEVICE_MEMORY`.
    DeviceMemory = -2,
    /// `VK_ERROR_INITIALIZATION_FAILED`.
    Initialization = -3,
    /// `VK_ERROR_DEVICE_LOST`: from then on, the device and its queue answer nothing else.
    DeviceLost = -4,
    /// `VK_ERROR_MEMORY_MAP_FAILED`.
    MemoryMap = -5,
    /// `VK_ERROR_LAYER_NOT_PRESENT`.
    LayerNotPresent = -6,
    /// `VK_ERROR_EXTENSION_NOT_PRESENT`.
    ExtensionNotPresent = -7,
    /// `VK_ERROR_FEATURE_NOT_PRESENT`.
    FeatureNotPresent = -8,
    /// `VK_ERROR_INCOMPATIBLE_DRIVER`.
    IncompatibleDriver = -9,
    /// `VK_ERROR_TOO_MANY_OBJECTS`.
    TooManyObjects = -10,
    /// `VK_ERROR_FORMAT_NOT_SUPPORTED`.
    FormatNotSupported = -11,
    /// `VK_ERROR_FRAGMENTED_POOL`.
    FragmentedPool = -12,
    /// `VK_ERROR_UNKNOWN`: any call may answer it.
    Unknown = -13,
    /// `VK_ERROR_SURFACE_LOST_KHR`.
    SurfaceLost = -1_000_000_000,
    /// `VK_ERROR_NATIVE_WINDOW_IN_USE_KHR`.
    WindowInUse = -1_000_000_001,
    /// `VK_ERROR_OUT_OF_DATE_KHR`.
    OutOfDate = -1_000_001_004,
    /// `VK_ERROR_OUT_OF_POOL_MEMORY`.
    PoolMemory = -1_000_069_000,
    /// `VK_ERROR_FRAGMENTATION`.
    Fragmentation = -1_000_161_000,
    /// `VK_SUBOPTIMAL_KHR`: the call has done its work.
    Suboptimal = 1_000_001_003,
}

use Fault::{
    DeviceLost, DeviceMemory, ExtensionNotPresent, FeatureNotPresent, FormatNotSupported, Fragmentation,
    FragmentedPool, HostMemory, IncompatibleDriver, Initialization, LayerNotPresent, MemoryMap, OutOfDate, PoolMemory,
    Suboptimal, SurfaceLost, TooManyObjects, Unknown, WindowInUse,
};

/// Every call of raxel that may fail, with its possible answers (the reference pages of Vulkan 1.3, "Return Codes").
pub(crate) const CALLS: &[(&str, &[Fault])] = &[
    ("vkEnumerateInstanceExtensionProperties", &[HostMemory, DeviceMemory, LayerNotPresent, Unknown]),
    ("vkEnumerateInstanceLayerProperties", &[HostMemory, DeviceMemory, Unknown]),
    (
        "vkCreateInstance",
        &[HostMemory, DeviceMemory, Initialization, LayerNotPresent, ExtensionNotPresent, IncompatibleDriver, Unknown],
    ),
    ("vkCreateDebugUtilsMessengerEXT", &[HostMemory, Unknown]),
    ("vkEnumeratePhysicalDevices", &[HostMemory, DeviceMemory, Initialization, Unknown]),
    ("vkEnumerateDeviceExtensionProperties", &[HostMemory, DeviceMemory, LayerNotPresent, Unknown]),
    ("vkGetPhysicalDeviceImageFormatProperties", &[HostMemory, DeviceMemory, FormatNotSupported, Unknown]),
    (
        "vkCreateDevice",
        &[
            HostMemory,
            DeviceMemory,
            Initialization,
            TooManyObjects,
            DeviceLost,
            ExtensionNotPresent,
            FeatureNotPresent,
            Unknown,
        ],
    ),
    ("vkSetDebugUtilsObjectNameEXT", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateSemaphore", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateFence", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateCommandPool", &[HostMemory, DeviceMemory, Unknown]),
    ("vkAllocateCommandBuffers", &[HostMemory, DeviceMemory, Unknown]),
    ("vkResetCommandPool", &[DeviceMemory, Unknown]),
    ("vkBeginCommandBuffer", &[HostMemory, DeviceMemory, Unknown]),
    ("vkEndCommandBuffer", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateBuffer", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateImage", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateImageView", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateSampler", &[HostMemory, DeviceMemory, TooManyObjects, Unknown]),
    ("vkAllocateMemory", &[HostMemory, DeviceMemory, TooManyObjects, Unknown]),
    ("vkMapMemory", &[HostMemory, DeviceMemory, MemoryMap, Unknown]),
    ("vkBindBufferMemory", &[HostMemory, DeviceMemory, Unknown]),
    ("vkBindImageMemory", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateShaderModule", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateDescriptorSetLayout", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreatePipelineLayout", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreatePipelineCache", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateComputePipelines", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateGraphicsPipelines", &[HostMemory, DeviceMemory, Unknown]),
    ("vkGetPipelineCacheData", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateDescriptorPool", &[HostMemory, DeviceMemory, Fragmentation, Unknown]),
    ("vkAllocateDescriptorSets", &[HostMemory, DeviceMemory, FragmentedPool, PoolMemory, Unknown]),
    ("vkCreateQueryPool", &[HostMemory, DeviceMemory, Unknown]),
    ("vkGetQueryPoolResults", &[HostMemory, DeviceMemory, DeviceLost, Unknown]),
    ("vkQueueSubmit2", &[HostMemory, DeviceMemory, DeviceLost, Unknown]),
    ("vkWaitSemaphores", &[HostMemory, DeviceMemory, DeviceLost, Unknown]),
    ("vkGetSemaphoreCounterValue", &[HostMemory, DeviceMemory, DeviceLost, Unknown]),
    ("vkWaitForFences", &[HostMemory, DeviceMemory, DeviceLost, Unknown]),
    ("vkDeviceWaitIdle", &[HostMemory, DeviceMemory, DeviceLost, Unknown]),
    ("vkCreateXlibSurfaceKHR", &[HostMemory, DeviceMemory, Unknown]),
    ("vkCreateXcbSurfaceKHR", &[HostMemory, DeviceMemory, Unknown]),
    ("vkGetPhysicalDeviceSurfaceSupportKHR", &[HostMemory, DeviceMemory, SurfaceLost, Unknown]),
    ("vkGetPhysicalDeviceSurfaceFormatsKHR", &[HostMemory, DeviceMemory, SurfaceLost, Unknown]),
    ("vkGetPhysicalDeviceSurfacePresentModesKHR", &[HostMemory, DeviceMemory, SurfaceLost, Unknown]),
    ("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", &[HostMemory, DeviceMemory, SurfaceLost, Unknown]),
    (
        "vkCreateSwapchainKHR",
        &[HostMemory, DeviceMemory, DeviceLost, SurfaceLost, Initialization, WindowInUse, Unknown],
    ),
    ("vkGetSwapchainImagesKHR", &[HostMemory, DeviceMemory, Unknown]),
    ("vkAcquireNextImageKHR", &[OutOfDate, SurfaceLost, Suboptimal, DeviceLost, HostMemory, DeviceMemory, Unknown]),
    ("vkQueuePresentKHR", &[OutOfDate, SurfaceLost, Suboptimal, DeviceLost, HostMemory, DeviceMemory, Unknown]),
];

/// As many of the cases, in an order that follows from the seed `RAXEL_FAULTS_SEED` alone.
pub(crate) fn chosen<Case>(cases: Vec<Case>, most: usize) -> Vec<Case> {
    let seed = std::env::var("RAXEL_FAULTS_SEED").map_or(1, |seed| seed.parse().expect("a number"));
    // SplitMix64 (Steele, Lea, Flood 2014).
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut keyed: Vec<(u64, Case)> =
        (1u64..).map(|i| mix(seed ^ i.wrapping_mul(0x9e37_79b9_7f4a_7c15))).zip(cases).collect();
    keyed.sort_by_key(|(key, _)| *key);
    keyed.into_iter().take(most).map(|(_, case)| case).collect()
}

/// The library. Every call of the table goes through `call`, which looks at the file `order`: a number, the name of a call, how many of them
/// are let through, what the next one answers, and whether all later ones do so, too. All words of a call have the size of a pointer in the calling conventions that this runs on.
const LIBRARY: &str = include_str!("faults.c");

/// How a program is run with the library before Vulkan.
pub(crate) struct Faults {
    library: PathBuf,
    order: PathBuf,
    seen: PathBuf,
    number: std::cell::Cell<u32>,
}

impl Faults {
    /// Makes the library in a folder of the project.
    pub(crate) fn new(project: &Project) -> Self {
        let names: Vec<String> = CALLS.iter().map(|(name, _)| format!("\"{name}\"")).collect();
        let lossy = |faults: &[Fault]| u8::from(faults.contains(&DeviceLost));
        let can_lose: Vec<String> = CALLS.iter().map(|(_, faults)| lossy(faults).to_string()).collect();
        let tables = format!(
            "static const char *names[] = {{{}}};\nstatic const char can_lose[] = {{{}}};\n",
            names.join(", "),
            can_lose.join(", ")
        );
        let words = "Word a, Word b, Word c, Word d, Word e, Word f, Word g, Word h";
        let slot = |n: usize| format!("static int call_{n}({words}) {{ return call({n}, a, b, c, d, e, f, g, h); }}\n");
        let slots: String = (0..CALLS.len()).map(slot).collect();
        let all: Vec<String> = (0..CALLS.len()).map(|n| format!("call_{n}")).collect();
        let ours = format!(
            r#"static const Call our_calls[] = {{{}}};
static Function ours(const char *name, Function found) {{
    if (!strcmp(name, "vkQueueWaitIdle")) queue_idle = (void *)found;
    if (!strcmp(name, "vkGetDeviceQueue")) {{ get_queue = (void *)found; return (Function)note_queue; }}
    if (!strcmp(name, "vkDestroyDevice")) {{ destroy = (void *)found; return (Function)note_end; }}
    for (int n = 0; n < CALLS; n++)
        if (!strcmp(name, names[n])) {{ found_calls[n] = (Call)found; return (Function)our_calls[n]; }}
    return found;
}}
"#,
            all.join(", ")
        );
        let library = before_vulkan(project, &[&tables, LIBRARY, &slots, &ours].concat());
        let faults = Self {
            library,
            order: project.path("faults.order"),
            seen: project.path("faults.seen"),
            number: std::cell::Cell::new(0),
        };
        faults.write("none 0 0 0");
        fs::write(&faults.seen, "").unwrap();
        faults
    }

    /// The command that runs the other end in a child process, which knows the project's folder.
    pub(crate) fn in_folder(folder: &Path) -> Self {
        let [order, seen] = ["faults.order", "faults.seen"].map(|name| folder.join(name));
        // No number of the parent process comes again.
        Self { library: PathBuf::new(), order, seen, number: std::cell::Cell::new(1000) }
    }

    /// Variables of a program's environment.
    pub(crate) fn variables(&self) -> [(&'static str, &Path); 3] {
        [("LD_PRELOAD", &self.library), ("FAULTS_ORDER", &self.order), ("FAULTS_SEEN", &self.seen)]
    }

    /// The next call of this name after `skip` of them fails, once.
    pub(crate) fn arm(&self, call: &str, skip: usize, fault: Fault) {
        // The calls before it do not count.
        fs::write(&self.seen, "").unwrap();
        self.write(&format!("{call} {skip} {} 0", fault as i32));
    }

    /// Every call of this name fails.
    pub(crate) fn arm_always(&self, call: &str, fault: Fault) {
        fs::write(&self.seen, "").unwrap();
        self.write(&format!("{call} 0 {} 1", fault as i32));
    }

    /// From here on nothing fails. Returns the calls since the last order: names, and the planted answers.
    pub(crate) fn disarm(&self) -> Vec<(String, i32)> {
        self.write("none 0 0 0");
        let seen = fs::read_to_string(&self.seen).unwrap();
        let before = (self.number.get() - 1).to_string();
        let line = |line: &str| {
            let mut words = line.split(' ');
            let number = words.next()?;
            (number == before).then(|| Some((words.next()?.to_owned(), words.next()?.parse().ok()?)))?
        };
        seen.lines().filter_map(line).collect()
    }

    fn write(&self, order: &str) {
        self.number.set(self.number.get() + 1);
        // In one write, and long enough for any: the library reads it at every call.
        let line = format!("{} {order}", self.number.get());
        let mut file = fs::OpenOptions::new().write(true).create(true).truncate(false).open(&self.order).unwrap();
        std::io::Write::write_all(&mut file, format!("{line:<100}\n").as_bytes()).unwrap();
    }
}
