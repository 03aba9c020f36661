#include <cstdio>
#include <cstdlib>
#include <vector>
#include <cstring>
#include <ctime>
#include <planish/planish.h>
using namespace std;
static double now(){timespec t;clock_gettime(CLOCK_MONOTONIC,&t);return t.tv_sec+1e-9*t.tv_nsec;}
static int cb(const planish_progress*p,void*){if(p->sweep_done)printf("  sweep %d rms %.6f movable %.6f visits %ld %.2f ms\n",p->sweep,p->rms,p->rms_movable,(long)p->visits,p->seconds*1e3);return 0;}
int main(int argc,char**argv){
  FILE*f=fopen(argv[1],"r"); char w[100]; int n=0; vector<double> X; vector<int> T;
  while(fscanf(f,"%99s",w)==1){ if(!strcmp(w,"Vertices")){ fscanf(f,"%d",&n); X.resize(3*n); for(int i=0;i<n;i++){int r;fscanf(f,"%lf %lf %lf %d",&X[3*i],&X[3*i+1],&X[3*i+2],&r);} }
    else if(!strcmp(w,"Tetrahedra")){int m;fscanf(f,"%d",&m);T.resize(4*m);for(int i=0;i<m;i++){int r;fscanf(f,"%d %d %d %d %d",&T[4*i],&T[4*i+1],&T[4*i+2],&T[4*i+3],&r);for(int j=0;j<4;j++)T[4*i+j]--; }}}
  planish_mesh M={3,n,(int64_t)T.size()/4,X.data(),T.data(),NULL}; planish_options o;planish_options_init(&o);o.threads=argc>2?atoi(argv[2]):1;o.isa=(planish_isa)(argc>3?atoi(argv[3]):0);o.bind=1;if(argc>4)o.progress=cb;
  planish_error e;planish_plan*p;for(int r=0;r<3;r++){double t0=now();if(planish_plan_create(&M,&o,&p,&e)){printf("%s\n",e.text);return 1;}printf("setup %.2f ms\n",(now()-t0)*1e3);if(r<2)planish_plan_destroy(p);}
  planish_plan_info i;planish_plan_get_info(p,&i);printf("free %ld colours %d fixedel %ld bf %ld thr %d %s bytes %ld per tet %.1f\n",i.n_free,i.n_colours,i.n_fixed_elements,i.n_boundary_facets,i.threads,i.binding,i.bytes,(double)i.bytes/M.n_elements);
  planish_result R; if(planish_smooth(p,X.data(),&o,&R,&e)){printf("%s\n",e.text);return 1;}
  printf("stop %d sweeps %d visits %ld moved %ld maxd %g inv %ld rms %.6f %.6f sec %.4f\n",R.stop,R.sweeps,R.visits,R.moved_nodes,R.max_displacement,R.inverted,R.rms,R.rms_movable,R.seconds);
  unsigned long long h=1469598103934665603ull;for(double x:X){unsigned long long b;memcpy(&b,&x,8);h=(h^b)*1099511628211ull;}printf("hash %llx\n",h);
}
