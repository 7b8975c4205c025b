/* A planner that does what its parameter says, where it says: what must not harm the harness. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#ifdef __linux__
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/shm.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#endif

#include "vb_planner.h"

VB_PLANNER_METADATA("hostile", "1.0.0", "A", "Does harm", "0.1",
                    VB_PARAM("what", "nothing", "the harm") VB_PARAM("where", "step", "init, step or free"));

static int calls;
/* The command that is to be filled, during a step. */
static vb_command *due;

struct planner {
    char what[64];
    char where[16];
};

static const char *param(const vb_task *task, const char *key) {
    for (size_t i = 0; i < task->params_len; i++)
        if (strcmp(task->params[i].key, key) == 0) return task->params[i].value;
    return "";
}

static void *thread(void *unused) {
    for (;;) pause();
    return unused;
}

static void handler(int signal) { (void)signal; }

static int deep(volatile char *outer) {
    volatile char inner[4096];
    inner[0] = outer ? outer[0] : 1;
    return deep(inner) + inner[0];
}

/* The answer to a request, forged: {"command": {...}} with a throttle of 1. */
static void forge(int descriptor, const char *bytes, size_t count) {
    if (write(descriptor, bytes, count) < 0) abort();
}

static int32_t harm(const char *what, const vb_host *host, vb_error *error) {
    if (strcmp(what, "segfault") == 0) *(volatile int *)8 = 1;
    if (strcmp(what, "abort") == 0) abort();
    if (strcmp(what, "exit") == 0) exit(3);
    if (strcmp(what, "exit-0") == 0) exit(0);
    if (strcmp(what, "spin") == 0)
        for (;;) calls++;
    if (strcmp(what, "sleep") == 0) sleep(1000);
    if (strcmp(what, "fork") == 0)
        for (;;) fork();
    if (strcmp(what, "exec") == 0) execl("/bin/sh", "sh", "-c", "touch /tmp/vb-hostile", (char *)NULL);
    if (strcmp(what, "socket") == 0) socket(AF_INET, SOCK_STREAM, 0);
    if (strcmp(what, "kill") == 0) kill(getppid(), 0);
    if (strcmp(what, "fpe") == 0) raise(SIGFPE);
    if (strcmp(what, "ill") == 0) __builtin_trap();
    if (strcmp(what, "stop") == 0) raise(SIGSTOP);
    if (strcmp(what, "double-free") == 0) {
        void *volatile block = malloc(4000);
        free(block);
        free(block);
        abort(); /* where the C library doesn't notice */
    }
    if (strcmp(what, "scream") == 0)
        for (;;) fprintf(stderr, "aaaaaaaaaaaaaaaa");
    if (strcmp(what, "stack") == 0) deep(NULL);
    if (strcmp(what, "memory") == 0) {
        for (;;) {
            char *block = malloc(1 << 20);
            memset(block, 1, 1 << 20); /* crashes at last: nobody looks at NULL */
        }
    }
    if (strcmp(what, "close") == 0)
        for (int i = 0; i < 1024; i++) close(i);
    if (strcmp(what, "garbage") == 0) forge(4, "\x05\0\0\0hello", 9);
    if (strcmp(what, "huge") == 0) forge(4, "\xff\xff\xff\x7f", 4);
    if (strcmp(what, "text") == 0) forge(4, "hello\n", 6);
    if (strcmp(what, "twice") == 0) forge(4, "\x08\0\0\0\x81\xa5ready\x80", 12);
#ifdef __linux__
    if (strcmp(what, "trace") == 0) ptrace(PTRACE_ATTACH, getppid(), NULL, NULL);
    if (strcmp(what, "poke") == 0) {
        struct iovec here = {&calls, sizeof calls}, there = {(void *)8, sizeof calls};
        process_vm_writev(getppid(), &here, 1, &there, 1, 0);
    }
    if (strcmp(what, "share") == 0) shmget(IPC_PRIVATE, 4096, IPC_CREAT | 0600);
    if (strcmp(what, "alarm") == 0) {
        struct itimerval soon = {{0, 1000}, {0, 1000}};
        setitimer(ITIMER_REAL, &soon, NULL);
    }
    if (strcmp(what, "filter") == 0) syscall(SYS_seccomp, 1 /* SECCOMP_SET_MODE_FILTER */, 0, NULL);
    if (strcmp(what, "rules") == 0) syscall(446 /* landlock_restrict_self */, -1, 0);
    if (strcmp(what, "queue") == 0) syscall(SYS_rt_sigqueueinfo, getppid(), 0, NULL);
    if (strcmp(what, "pidfd") == 0) syscall(434 /* pidfd_open */, getppid(), 0);
    if (strcmp(what, "raise-kill") == 0) raise(SIGKILL);
    if (strcmp(what, "raise-term") == 0) raise(SIGTERM);
    int tried = 1, refused = 0;
    struct rlimit least = {1, 1};
    if (strcmp(what, "parents-limits") == 0) refused = prlimit(getppid(), RLIMIT_CPU, &least, NULL) != 0;
    else if (strcmp(what, "own") == 0) refused = fcntl(3, F_SETOWN, getppid()) != 0;
    else if (strcmp(what, "signal") == 0) refused = fcntl(3, F_SETSIG, SIGKILL) != 0;
    else if (strcmp(what, "async") == 0) refused = fcntl(3, F_SETFL, O_ASYNC) != 0;
    else if (strcmp(what, "pipe") == 0) refused = fcntl(3, F_SETPIPE_SZ, 1 << 20) < 0;
    else if (strcmp(what, "survive") == 0) refused = prctl(PR_SET_PDEATHSIG, 0) != 0;
    else if (strcmp(what, "dumpable") == 0) refused = prctl(PR_SET_DUMPABLE, 1) != 0;
    else if (strcmp(what, "filter-prctl") == 0) refused = prctl(PR_SET_SECCOMP, 2, NULL) != 0 && errno == EPERM;
    else tried = 0;
    if (tried) {
        snprintf(error->message, sizeof error->message, "%s", refused ? "it is refused" : "it is open");
        return 1;
    }
    if (strcmp(what, "shared") == 0 || strcmp(what, "downwards") == 0) {
        int flags = MAP_ANONYMOUS | (strcmp(what, "shared") == 0 ? MAP_SHARED : MAP_PRIVATE | MAP_GROWSDOWN);
        void *block = mmap(NULL, 1 << 20, PROT_READ | PROT_WRITE, flags, -1, 0);
        snprintf(error->message, sizeof error->message, "%s", block == MAP_FAILED ? "no such memory" : "it is open");
        return 1;
    }
    if (strcmp(what, "itself") == 0 || strcmp(what, "folder") == 0) {
        Dl_info info = {"", NULL, NULL, NULL};
        dladdr(&calls, &info);
        int file = open(strcmp(what, "itself") == 0 ? info.dli_fname : "/usr/lib", O_RDONLY);
        snprintf(error->message, sizeof error->message, "%s", file < 0 ? "it can't be opened" : "it is open");
        return 1;
    }
    if (strcmp(what, "remove") == 0) unlinkat(AT_FDCWD, "/tmp/vb-hostile", 0);
#endif
    if (strcmp(what, "gear") == 0 && due) due->gear = 7;
    if (strcmp(what, "nan") == 0 && due) due->steering = 0.0 / 0.0;
    if (strcmp(what, "inf") == 0 && due) due->throttle = 1.0 / 0.0;
    if (strcmp(what, "flood") == 0 && due) {
        static float values[1 << 20];
        static vb_series series = {"flood", values, 1 << 20};
        due->debug = &series;
    }
    if (strcmp(what, "nowhere") == 0 && due) {
        due->debug = (const vb_series *)8;
        due->debug_len = 1000;
    }
    if (strcmp(what, "mute") == 0) return -1;
    if (strcmp(what, "escape") == 0) {
        snprintf(error->message, sizeof error->message, "no way\033[2J\a");
        return 1;
    }
    if (strcmp(what, "library") == 0) {
        void *library = dlopen("libresolv.so.2", RTLD_NOW);
        snprintf(error->message, sizeof error->message, "%s", library ? "it is open" : "it can't be opened");
        return 1;
    }
    if (strcmp(what, "limits") == 0) {
        struct rlimit none = {RLIM_INFINITY, RLIM_INFINITY};
        int refused = setrlimit(RLIMIT_AS, &none) != 0 && setrlimit(RLIMIT_CORE, &none) != 0;
        snprintf(error->message, sizeof error->message, refused ? "no other limits" : "limits are gone");
        return 1;
    }
    if (strcmp(what, "wait") == 0) {
        char number[32];
        snprintf(number, sizeof number, "%d", (int)getpid());
        host->log(host->context, VB_LOG_INFO, number);
        for (;;) calls++;
    }
    if (strcmp(what, "talk") == 0)
        for (;;) host->log(host->context, VB_LOG_INFO, "la la la");
    if (strcmp(what, "print") == 0) {
        printf("to standard output\n");
        fflush(stdout);
        fprintf(stderr, "to standard error \033[2J\n");
        int standard = getchar();
        snprintf(error->message, sizeof error->message, "standard input gives %d", standard);
        return 1;
    }
    if (strcmp(what, "mutter") == 0) printf("said without a flush\n");
    if (strcmp(what, "passwd") == 0 || strcmp(what, "write") == 0) {
        int file = strcmp(what, "passwd") == 0 ? open("/etc/passwd", O_RDONLY)
                                               : open("/tmp/vb-hostile", O_WRONLY | O_CREAT, 0600);
        snprintf(error->message, sizeof error->message, file < 0 ? "it can't be opened" : "it is open");
        return 1;
    }
    if (strcmp(what, "thread") == 0) {
        pthread_t id;
        int status = pthread_create(&id, NULL, thread, NULL);
        snprintf(error->message, sizeof error->message, status == 0 ? "it runs" : "no thread");
        return 1;
    }
    if (strcmp(what, "handler") == 0) {
        int refused = signal(SIGSEGV, handler) == SIG_ERR && signal(SIGSYS, handler) == SIG_ERR;
        snprintf(error->message, sizeof error->message, refused ? "no handler" : "it is handled");
        return 1;
    }
    if (strcmp(what, "environment") == 0) {
        extern char **environ;
        snprintf(error->message, sizeof error->message, "first variable: %s", environ && environ[0] ? environ[0] : "none");
        return 1;
    }
    return 0;
}

static int32_t init(const vb_task *task, const vb_host *host, void **planner, vb_error *error) {
    struct planner *p = calloc(1, sizeof *p);
    snprintf(p->what, sizeof p->what, "%s", param(task, "what"));
    snprintf(p->where, sizeof p->where, "%s", param(task, "where"));
    *planner = p;
    return strcmp(p->where, "init") == 0 ? harm(p->what, host, error) : 0;
}

static int32_t step(void *planner, const vb_observation *o, const vb_host *host, vb_command *command, vb_error *error) {
    static const float values[2] = {1.5f, -2.0f};
    static vb_series series = {"pair", values, 2};
    struct planner *p = planner;
    calls++;
    command->steering = o->time;
    command->throttle = calls;
    command->debug = &series;
    command->debug_len = 1;
    due = command;
    int32_t status = strcmp(p->where, "step") == 0 ? harm(p->what, host, error) : 0;
    due = NULL;
    return status;
}

static void release(void *planner) {
    struct planner *p = planner;
    vb_host host = {sizeof host, NULL, NULL};
    vb_error error;
    if (strcmp(p->where, "free") == 0) harm(p->what, &host, &error);
    free(p);
}

__attribute__((constructor)) static void loaded(void) {
#ifdef HARM_AT_LOAD
    vb_host host = {sizeof host, NULL, NULL};
    static vb_error error;
    static const char *const let[] = {"it is open", "limits are gone", "it runs", "it is handled"};
    int failed = harm(HARM_AT_LOAD, &host, &error);
    for (int i = 0; i < 4; i++)
        if (failed && strcmp(error.message, let[i]) == 0) exit(9);
#endif
}

VB_PLANNER_EXPORT(init, step, release);
