from mpmath import *
mp.dps=60
def bench():
    d=dict(w='1.02',c='0.08',g='9.81',rR='0.3',mR='2',IRxx='0.0603',IRyy='0.12',xB='0.3',zB='-0.9',mB='85',IBxx='9.2',IBzz='2.8',IBxz='2.4',xH='0.9',zH='-0.7',mH='4',IHxx='0.05892',IHzz='0.00708',IHxz='-0.00756',rF='0.35',mF='3',IFxx='0.1405',IFyy='0.28')
    d={k:mpf(v) for k,v in d.items()}; d['lam']=pi/10
    return d
def mats(p):
    # independent route: Lagrangian-free formulas of the 1-2: sums over bodies about the steer axis
    w,c,lam=p['w'],p['c'],p['lam']; s,co=sin(lam),cos(lam)
    mT=p['mR']+p['mB']+p['mH']+p['mF']
    bodies=[(p['mR'],mpf(0),-p['rR'],p['IRxx'],p['IRxx'],mpf(0)),(p['mB'],p['xB'],p['zB'],p['IBxx'],p['IBzz'],p['IBxz']),(p['mH'],p['xH'],p['zH'],p['IHxx'],p['IHzz'],p['IHxz']),(p['mF'],w,-p['rF'],p['IFxx'],p['IFxx'],mpf(0))]
    mx=sum(b[0]*b[1] for b in bodies); mz=sum(b[0]*b[2] for b in bodies)
    Ixx=sum(b[3]+b[0]*b[2]**2 for b in bodies); Izz=sum(b[4]+b[0]*b[1]**2 for b in bodies); Ixz=sum(b[5]-b[0]*b[1]*b[2] for b in bodies)
    A=bodies[2:]
    # lateral displacement per steer at each body: u = (x-w-c)cos - z sin; rotation (s,0,co)
    mu_=sum(b[0]*((b[1]-w-c)*co-b[2]*s) for b in A)
    Ill=sum(b[0]*((b[1]-w-c)*co-b[2]*s)**2+b[3]*s*s+2*b[5]*s*co+b[4]*co*co for b in A)
    Ilx=sum(-b[0]*((b[1]-w-c)*co-b[2]*s)*b[2]+b[3]*s+b[5]*co for b in A)
    Ilz=sum(b[0]*((b[1]-w-c)*co-b[2]*s)*b[1]+b[5]*s+b[4]*co for b in A)
    SF=p['IFyy']/p['rF']; SR=p['IRyy']/p['rR']; ST=SF+SR
    m=c*co/w; SA=mu_+m*mx
    M=matrix([[Ixx,Ilx+m*Ixz],[Ilx+m*Ixz,Ill+2*m*Ilz+m*m*Izz]])
    K0=matrix([[mz,-SA],[-SA,-SA*s]]); K2=matrix([[0,(ST-mz)/w*co],[0,(SA+SF*s)/w*co]])
    C1=matrix([[0,m*ST+SF*co+Ixz/w*co-m*mz],[-(m*ST+SF*co),Ilz/w*co+m*(SA+Izz/w*co)]])
    return M,C1,K0,K2
def coef(p,v):
    M,C1,K0,K2=mats(p); C=v*C1; K=p['g']*K0+v*v*K2
    a=[(M[i,j],C[i,j],K[i,j]) for i,j in((0,0),(1,1),(0,1),(1,0))]
    def mul(x,y):
        r=[mpf(0)]*5
        for i in range(3):
            for j in range(3): r[i+j]+=x[i]*y[j]
        return r
    x,y=mul(a[0],a[1]),mul(a[2],a[3])
    return [x[i]-y[i] for i in range(5)]
def eig(p,v): return sorted(polyroots(coef(p,v),maxsteps=500,extraprec=400),key=lambda z:(re(z),im(z)))
p=bench()
M,C1,K0,K2=mats(p)
for X in (M,C1,K0,K2): print([[nstr(X[i,j],16) for j in range(2)] for i in range(2)])
for v in range(11): print(v,[(nstr(re(z),17),nstr(im(z),17)) for z in eig(p,mpf(v))])
def hurw(v):
    a,b,c_,d,e=coef(p,v); return b*c_*d-a*d*d-b*b*e
vw=findroot(hurw,mpf('4.29')); print('vw',nstr(vw,18),[(nstr(re(z),17),nstr(im(z),17)) for z in eig(p,vw)])
vc=findroot(lambda v:coef(p,v)[4],mpf(6)); print('vc',nstr(vc,18), [(nstr(re(z),17),nstr(im(z),17)) for z in eig(p,vc)])
f=lambda s,v: polyval(coef(p,v),s); 
def F(s,v):
    co=coef(p,v); return [polyval(co,s), 4*co[0]*s**3+3*co[1]*s*s+2*co[2]*s+co[3]]
r=findroot(F,(mpf('3.78'),mpf('0.684'))); print('vd',nstr(r[1],18),nstr(r[0],18))
