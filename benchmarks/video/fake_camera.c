/*
 * A V4L2 camera in a preload library: it answers a program's calls for /dev/video0 with JPEGs from a file, so that a
 * streaming server can be measured without a camera and without kernel modules.
 *
 *   cc -shared -fPIC -O2 -o fake_camera.so fake_camera.c -ldl
 *   FRAMES=pictures.bin FPS=30 LD_PRELOAD=./fake_camera.so ustreamer --device=/dev/video0 --format=JPEG --encoder=HW
 *
 * FRAMES: a count, then for each picture its length (u32, little-endian) and its JPEG. Each picture is stamped when it
 * is handed over: a JPEG comment behind the start marker holds CLOCK_MONOTONIC, nanoseconds, 16 hexadecimal digits.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#define DEVICE "/dev/video0"
#define BUFFERS 32
#define BUFFER_BYTES (4u << 20)
#define STAMP_BYTES 20u

static int camera = -1; /* a timer is the device: it can be read whenever a picture is due */
static uint8_t *memory[BUFFERS];
static unsigned waiting[BUFFERS], first_waiting, count_waiting;
static uint8_t **pictures;
static uint32_t *lengths, picture_count, next_picture, sequence;
static uint32_t width = 1280, height = 720;

static void *real(const char *name) {
	void *found = dlsym(RTLD_NEXT, name);
	if (found == NULL)
		abort();
	return found;
}

static uint32_t read_number(FILE *file) {
	uint32_t number;
	if (fread(&number, sizeof number, 1, file) != 1)
		abort();
	return number;
}

static void read_pictures(void) {
	const char *path = getenv("FRAMES");
	FILE *file = path ? fopen(path, "rb") : NULL;
	if (file == NULL) {
		fprintf(stderr, "fake camera: set FRAMES to a file of pictures\n");
		abort();
	}
	picture_count = read_number(file);
	pictures = calloc(picture_count, sizeof *pictures);
	lengths = calloc(picture_count, sizeof *lengths);
	for (uint32_t i = 0; i < picture_count; i++) {
		lengths[i] = read_number(file);
		if (lengths[i] < 4 || lengths[i] + STAMP_BYTES > BUFFER_BYTES)
			abort();
		pictures[i] = malloc(lengths[i]);
		if (fread(pictures[i], 1, lengths[i], file) != lengths[i])
			abort();
	}
	fclose(file);
}

static int open_camera(void) {
	if (pictures == NULL)
		read_pictures();
	long fps = atol(getenv("FPS") ? getenv("FPS") : "30");
	struct itimerspec each = {{0, 1000000000L / fps}, {0, 1000000000L / fps}};
	camera = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK);
	timerfd_settime(camera, 0, &each, NULL);
	first_waiting = count_waiting = 0;
	return camera;
}

static int give_picture(struct v4l2_buffer *buffer) {
	uint64_t due;
	if (count_waiting == 0 || read(camera, &due, sizeof due) != sizeof due) {
		errno = EAGAIN;
		return -1;
	}
	unsigned index = waiting[first_waiting];
	first_waiting = (first_waiting + 1) % BUFFERS;
	count_waiting--;
	uint32_t which = next_picture++ % picture_count;
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	char digits[17];
	snprintf(digits, sizeof digits, "%016llx",
		 (unsigned long long)now.tv_sec * 1000000000ull + (unsigned long long)now.tv_nsec);
	uint8_t *to = memory[index];
	memcpy(to, "\xff\xd8\xff\xfe\x00\x12", 6);
	memcpy(to + 6, digits, 16);
	memcpy(to + 22, pictures[which] + 2, lengths[which] - 2);
	buffer->index = index;
	buffer->bytesused = lengths[which] + STAMP_BYTES;
	buffer->length = BUFFER_BYTES;
	buffer->flags = 0;
	buffer->sequence = sequence++;
	buffer->memory = V4L2_MEMORY_MMAP;
	buffer->timestamp.tv_sec = now.tv_sec;
	buffer->timestamp.tv_usec = now.tv_nsec / 1000;
	return 0;
}

static int answer(unsigned long request, void *argument) {
	switch ((uint32_t)request) {
	case (uint32_t)VIDIOC_QUERYCAP: {
		struct v4l2_capability *found = argument;
		memset(found, 0, sizeof *found);
		strcpy((char *)found->driver, "fake");
		found->device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
		found->capabilities = found->device_caps | V4L2_CAP_DEVICE_CAPS;
		return 0;
	}
	case (uint32_t)VIDIOC_S_FMT: {
		struct v4l2_format *asked = argument;
		width = asked->fmt.pix.width;
		height = asked->fmt.pix.height;
	} /* fall through */
	case (uint32_t)VIDIOC_G_FMT: {
		struct v4l2_format *format = argument;
		format->fmt.pix.width = width;
		format->fmt.pix.height = height;
		format->fmt.pix.pixelformat = V4L2_PIX_FMT_MJPEG;
		format->fmt.pix.field = V4L2_FIELD_ANY;
		format->fmt.pix.sizeimage = BUFFER_BYTES;
		format->fmt.pix.bytesperline = 0;
		return 0;
	}
	case (uint32_t)VIDIOC_REQBUFS: {
		struct v4l2_requestbuffers *asked = argument;
		if (asked->count > BUFFERS)
			asked->count = BUFFERS;
		return 0;
	}
	case (uint32_t)VIDIOC_QUERYBUF: {
		struct v4l2_buffer *buffer = argument;
		buffer->length = BUFFER_BYTES;
		buffer->m.offset = buffer->index * BUFFER_BYTES;
		return 0;
	}
	case (uint32_t)VIDIOC_QBUF:
		waiting[(first_waiting + count_waiting++) % BUFFERS] = ((struct v4l2_buffer *)argument)->index;
		return 0;
	case (uint32_t)VIDIOC_DQBUF:
		return give_picture(argument);
	case (uint32_t)VIDIOC_S_INPUT:
	case (uint32_t)VIDIOC_STREAMON:
	case (uint32_t)VIDIOC_STREAMOFF:
		return 0;
	default:
		errno = EINVAL;
		return -1;
	}
}

static void *buffer_at(off_t offset) {
	unsigned index = (unsigned)(offset / BUFFER_BYTES) % BUFFERS;
	if (memory[index] == NULL)
		memory[index] = aligned_alloc(4096, BUFFER_BYTES);
	return memory[index];
}

int open(const char *path, int flags, ...) {
	va_list more;
	va_start(more, flags);
	mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;
	va_end(more);
	if (!strcmp(path, DEVICE))
		return open_camera();
	return ((int (*)(const char *, int, ...))real("open"))(path, flags, mode);
}

int open64(const char *path, int flags, ...) {
	va_list more;
	va_start(more, flags);
	mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;
	va_end(more);
	if (!strcmp(path, DEVICE))
		return open_camera();
	return ((int (*)(const char *, int, ...))real("open64"))(path, flags, mode);
}

int access(const char *path, int mode) {
	if (!strcmp(path, DEVICE))
		return 0;
	return ((int (*)(const char *, int))real("access"))(path, mode);
}

void *mmap(void *at, size_t length, int protection, int flags, int descriptor, off_t offset) {
	if (descriptor >= 0 && descriptor == camera)
		return buffer_at(offset);
	void *(*call)(void *, size_t, int, int, int, off_t) = real("mmap");
	return call(at, length, protection, flags, descriptor, offset);
}

void *mmap64(void *at, size_t length, int protection, int flags, int descriptor, off_t offset) {
	if (descriptor >= 0 && descriptor == camera)
		return buffer_at(offset);
	void *(*call)(void *, size_t, int, int, int, off_t) = real("mmap64");
	return call(at, length, protection, flags, descriptor, offset);
}

int munmap(void *at, size_t length) {
	for (unsigned i = 0; i < BUFFERS; i++)
		if (at != NULL && memory[i] == at)
			return 0;
	return ((int (*)(void *, size_t))real("munmap"))(at, length);
}

int ioctl(int descriptor, unsigned long request, ...) {
	va_list more;
	va_start(more, request);
	void *argument = va_arg(more, void *);
	va_end(more);
	if (descriptor >= 0 && descriptor == camera)
		return answer(request, argument);
	return ((int (*)(int, unsigned long, ...))real("ioctl"))(descriptor, request, argument);
}
