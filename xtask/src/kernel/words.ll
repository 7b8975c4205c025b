; Where a thread notes its heap: memory of its block, which those who launch a kernel have to give it, a word for each thread.
@vb_slots = external addrspace(3) global [0 x ptr], align 8

define internal ptr @vb_slot() alwaysinline nounwind {
  %thread = call i32 @llvm.nvvm.read.ptx.sreg.tid.x()
  %number = zext i32 %thread to i64
  %place = getelementptr [0 x ptr], ptr addrspace(3) @vb_slots, i64 0, i64 %number
  %address = addrspacecast ptr addrspace(3) %place to ptr
  ret ptr %address
}

; Copies and fills of memory, a word at a time where addresses and size are whole words. LLVM's own for NVPTX go byte by byte, and
; wait for each.

define internal void @vb_copy(ptr %d, ptr %s, i64 %n) noinline nounwind {
entry:
  %di = ptrtoint ptr %d to i64
  %si = ptrtoint ptr %s to i64
  %o1 = or i64 %di, %si
  %o2 = or i64 %o1, %n
  %low = and i64 %o2, 7
  %al = icmp eq i64 %low, 0
  %e = getelementptr i8, ptr %s, i64 %n
  br i1 %al, label %w, label %b
w:
  %big = and i64 %n, -64
  %eb = getelementptr i8, ptr %s, i64 %big
  br label %wc
wc:
  %wd = phi ptr [ %d, %w ], [ %wd2, %wb ]
  %ws = phi ptr [ %s, %w ], [ %ws2, %wb ]
  %wdone = icmp eq ptr %ws, %eb
  br i1 %wdone, label %tc, label %wb
wb:
  %s1 = getelementptr i8, ptr %ws, i64 8
  %s2 = getelementptr i8, ptr %ws, i64 16
  %s3 = getelementptr i8, ptr %ws, i64 24
  %s4 = getelementptr i8, ptr %ws, i64 32
  %s5 = getelementptr i8, ptr %ws, i64 40
  %s6 = getelementptr i8, ptr %ws, i64 48
  %s7 = getelementptr i8, ptr %ws, i64 56
  %v0 = load i64, ptr %ws, align 8
  %v1 = load i64, ptr %s1, align 8
  %v2 = load i64, ptr %s2, align 8
  %v3 = load i64, ptr %s3, align 8
  %v4 = load i64, ptr %s4, align 8
  %v5 = load i64, ptr %s5, align 8
  %v6 = load i64, ptr %s6, align 8
  %v7 = load i64, ptr %s7, align 8
  %d1 = getelementptr i8, ptr %wd, i64 8
  %d2 = getelementptr i8, ptr %wd, i64 16
  %d3 = getelementptr i8, ptr %wd, i64 24
  %d4 = getelementptr i8, ptr %wd, i64 32
  %d5 = getelementptr i8, ptr %wd, i64 40
  %d6 = getelementptr i8, ptr %wd, i64 48
  %d7 = getelementptr i8, ptr %wd, i64 56
  store i64 %v0, ptr %wd, align 8
  store i64 %v1, ptr %d1, align 8
  store i64 %v2, ptr %d2, align 8
  store i64 %v3, ptr %d3, align 8
  store i64 %v4, ptr %d4, align 8
  store i64 %v5, ptr %d5, align 8
  store i64 %v6, ptr %d6, align 8
  store i64 %v7, ptr %d7, align 8
  %wd2 = getelementptr i8, ptr %wd, i64 64
  %ws2 = getelementptr i8, ptr %ws, i64 64
  br label %wc
tc:
  %td = phi ptr [ %wd, %wc ], [ %td2, %tb ]
  %ts = phi ptr [ %ws, %wc ], [ %ts2, %tb ]
  %tdone = icmp eq ptr %ts, %e
  br i1 %tdone, label %x, label %tb
tb:
  %tv = load i64, ptr %ts, align 8
  store i64 %tv, ptr %td, align 8
  %td2 = getelementptr i8, ptr %td, i64 8
  %ts2 = getelementptr i8, ptr %ts, i64 8
  br label %tc
b:
  %bd = phi ptr [ %d, %entry ], [ %bd2, %bb ]
  %bs = phi ptr [ %s, %entry ], [ %bs2, %bb ]
  %bdone = icmp eq ptr %bs, %e
  br i1 %bdone, label %x, label %bb
bb:
  %bv = load i8, ptr %bs, align 1
  store i8 %bv, ptr %bd, align 1
  %bd2 = getelementptr i8, ptr %bd, i64 1
  %bs2 = getelementptr i8, ptr %bs, i64 1
  br label %b
x:
  ret void
}

define internal void @vb_move(ptr %d, ptr %s, i64 %n) noinline nounwind {
entry:
  %di = ptrtoint ptr %d to i64
  %si = ptrtoint ptr %s to i64
  %gap = sub i64 %di, %si
  %fwd = icmp uge i64 %gap, %n
  br i1 %fwd, label %f, label %back
f:
  call void @vb_copy(ptr %d, ptr %s, i64 %n)
  ret void
back:
  %o1 = or i64 %di, %si
  %o2 = or i64 %o1, %n
  %low = and i64 %o2, 7
  %al = icmp eq i64 %low, 0
  br i1 %al, label %w, label %b
w:
  %wi = phi i64 [ %n, %back ], [ %wi2, %wb ]
  %wz = icmp eq i64 %wi, 0
  br i1 %wz, label %x, label %wb
wb:
  %wi2 = sub i64 %wi, 8
  %wp = getelementptr i8, ptr %s, i64 %wi2
  %wq = getelementptr i8, ptr %d, i64 %wi2
  %wv = load i64, ptr %wp, align 8
  store i64 %wv, ptr %wq, align 8
  br label %w
b:
  %i = phi i64 [ %n, %back ], [ %i2, %bb ]
  %z = icmp eq i64 %i, 0
  br i1 %z, label %x, label %bb
bb:
  %i2 = sub i64 %i, 1
  %p = getelementptr i8, ptr %s, i64 %i2
  %q = getelementptr i8, ptr %d, i64 %i2
  %v = load i8, ptr %p, align 1
  store i8 %v, ptr %q, align 1
  br label %b
x:
  ret void
}

define internal void @vb_fill(ptr %d, i8 %v, i64 %n) noinline nounwind {
entry:
  %di = ptrtoint ptr %d to i64
  %o = or i64 %di, %n
  %low = and i64 %o, 7
  %al = icmp eq i64 %low, 0
  %e = getelementptr i8, ptr %d, i64 %n
  %vw = zext i8 %v to i64
  %word = mul i64 %vw, 72340172838076673
  br i1 %al, label %w, label %b
w:
  %wd = phi ptr [ %d, %entry ], [ %wd2, %wb ]
  %wz = icmp eq ptr %wd, %e
  br i1 %wz, label %x, label %wb
wb:
  store i64 %word, ptr %wd, align 8
  %wd2 = getelementptr i8, ptr %wd, i64 8
  br label %w
b:
  %bd = phi ptr [ %d, %entry ], [ %bd2, %bb ]
  %bz = icmp eq ptr %bd, %e
  br i1 %bz, label %x, label %bb
bb:
  store i8 %v, ptr %bd, align 1
  %bd2 = getelementptr i8, ptr %bd, i64 1
  br label %b
x:
  ret void
}
